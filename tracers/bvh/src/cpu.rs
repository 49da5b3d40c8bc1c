//! `bvh-cpu`: CWBVH on the host.

mod watertight;

use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use glam::{UVec2, Vec2, Vec3A};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::faststack::{FastStack, HeapStack, StackStack};
use obvhs::ray::Ray as ObvhsRay;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use tracebench_api::{
    Counter, Geometry, Hit, HitBuffer, Ledger, MemoryReport, Parameter, ParameterScope, Parameters, PhaseClock, Query,
    Ray, Residency, Status, Structure, Surface, TraceJob, TraceTo, Tracer, TracerDescription, TracerError, Update,
    Viewpoint, choice, parameters,
};

use crate::hierarchy;
use crate::input::{BuildPreset, build_parameter, check_fits, gather, scale_for};
use crate::refit::refit;
use crate::sah;
use crate::wide::{check_references, depth};

use self::watertight::Watertight;

/// Rays handed to a core at a time: large against the cost of handing over, small against the ray sets.
const RAYS_PER_TASK: usize = 512;

/// Entries of obvhs's traversal stack, which overwrites its top in silence when full. A level pushes once at most; deeper
/// hierarchies (thousands of equal triangles give them) are traversed with a stack of their depth.
const STACK: usize = 32;

/// What `bvh-cpu` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "bvh-cpu",
        citation: "Ylitie, Karras, Laine: Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, \
                   HPG 2017; as in the obvhs crate",
        summary: "compressed eight-wide BVH, built and traversed on all cores of the host",
        residency: Residency::Host,
        ..TracerDescription::on_device(CpuParameters::describe())
    }
}

choice! {
    /// How a ray is tested against triangles, and how exactly against boxes.
    pub(crate) enum TriangleTest {
        MollerTrumbore = "moller_trumbore",
        Watertight = "watertight",
    }
}

parameters! {
    /// What `bvh-cpu` is told.
    pub(crate) struct CpuParameters {
        build: BuildPreset = build_parameter(),
        /// of the refits that follow a build every so many is a rebuild, because boxes grow as triangles drift apart: 1 makes all rebuilds,
        /// 0 none
        rebuild_every: u32 = Parameter::integer(ParameterScope::Build, 0..=1_000_000, 0)
            .unit("frames")
            .sweep([0, 1, 2, 4, 8, 16, 32]),
        /// the test of triangles: obvhs's (Moller, Trumbore 1997), which loses some rays through edges and vertices that triangles share,
        /// or one that loses none (Woop, Benthin, Wald 2013), in boxes that are wider by rounding
        triangle: TriangleTest = Parameter::choice(ParameterScope::Build, TriangleTest::MollerTrumbore)
            .improved(TriangleTest::Watertight),
    }
}

/// The tracer.
#[derive(Debug, Default)]
pub struct BvhCpu;

/// A built hierarchy.
struct BvhCpuStructure {
    /// Factor from scene units to those of the hierarchy, a power of two.
    scale: f32,
    bvh: CwBvh,
    /// Levels of nodes.
    depth: usize,
    triangles: Leaves,
    triangle_count: usize,
    /// What it was built or fitted over, shared with the scene: surfaces come from it.
    geometry: Geometry,
    /// Refits since the build.
    refits: u64,
    memory: MemoryReport,
}

impl Tracer for BvhCpu {
    fn build(
        &self,
        geometry: &Geometry,
        _viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        Ok(Box::new(BvhCpuStructure::build(geometry, &CpuParameters::try_from(parameters)?, clock)?))
    }
}

/// Triangles in the order of the leaves, so that a leaf's are neighbours, as their test wants them.
enum Leaves {
    /// A corner, two edges and a normal.
    Edges(Vec<RtTriangle>),
    /// The corners, which neighbours have the same bits of.
    Corners(Vec<Triangle>),
}

impl Leaves {
    fn new(bvh: &CwBvh, triangles: &[Triangle], test: TriangleTest, clock: &mut PhaseClock<'_>) -> Self {
        let ordered = || bvh.primitive_indices.par_iter().map(|index| &triangles[*index as usize]);
        clock.host_phase("order triangles", || match test {
            TriangleTest::MollerTrumbore => Self::Edges(ordered().map(RtTriangle::from).collect()),
            TriangleTest::Watertight => Self::Corners(ordered().copied().collect()),
        })
    }

    /// Bytes of a triangle, triangles that there is room for, and triangles.
    fn size(&self) -> [usize; 3] {
        match self {
            Self::Edges(triangles) => [size_of::<RtTriangle>(), triangles.capacity(), triangles.len()],
            Self::Corners(triangles) => [size_of::<Triangle>(), triangles.capacity(), triangles.len()],
        }
    }
}

/// A ray's test of boxes and triangles.
trait Test {
    /// Bits of the children that it meets, as obvhs's traversal wants them.
    fn children(&self, node: &CwBvhNode, ray: &ObvhsRay, octants: u32) -> u32;
    /// Where it meets the triangle of a slot; beyond its end for none.
    fn t(&self, slot: usize, ray: &ObvhsRay) -> f32;
    /// The weights of the second and third corner there.
    fn weights(&self, slot: usize, ray: &ObvhsRay) -> Vec2;
}

/// obvhs's own.
impl Test for &[RtTriangle] {
    fn children(&self, node: &CwBvhNode, ray: &ObvhsRay, octants: u32) -> u32 {
        node.intersect_ray(ray, octants)
    }

    fn t(&self, slot: usize, ray: &ObvhsRay) -> f32 {
        self[slot].intersect(ray)
    }

    fn weights(&self, slot: usize, ray: &ObvhsRay) -> Vec2 {
        self[slot].compute_barycentric(ray)
    }
}

impl BvhCpuStructure {
    fn build(
        geometry: &Geometry,
        parameters: &CpuParameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<BvhCpuStructure, TracerError> {
        let scale = scale_for(geometry.diagonal());
        let triangles = gather(geometry, scale, clock);
        let mut ledger = Ledger::new();
        ledger.borrow_transient(size_of_val(triangles.as_slice()) as u64);
        let bvh = hierarchy::build_wide(&triangles, parameters.build.values(), &mut ledger, clock);
        let ordered = Leaves::new(&bvh, &triangles, parameters.triangle, clock);

        let mut keep = |name: &str, element: usize, capacity: usize, used: usize| {
            ledger.keep(name, (capacity * element) as u64, (used * element) as u64);
        };
        keep("CWBVH nodes", size_of::<CwBvhNode>(), bvh.nodes.capacity(), bvh.nodes.len());
        keep("primitive indices", 4, bvh.primitive_indices.capacity(), bvh.primitive_indices.len());
        let [element, capacity, used] = ordered.size();
        keep("triangles in leaf order", element, capacity, used);
        let depth = depth(&bvh)?;
        Ok(BvhCpuStructure {
            scale,
            bvh,
            depth,
            triangles: ordered,
            triangle_count: triangles.len(),
            geometry: geometry.clone(),
            refits: 0,
            memory: ledger.report(0).with_surface_geometry(geometry.surface_bytes()),
        })
    }

    /// Boxes and triangles follow the vertices. Triangles that the build split keep several boxes, each now of the whole
    /// triangle. With `rebuild_every` a refit in so many is a rebuild; the phases say which it was.
    fn refit(
        &mut self,
        geometry: &Geometry,
        parameters: &CpuParameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        check_fits(self.triangle_count, geometry)?;
        let rebuild_every = u64::from(parameters.rebuild_every);
        if rebuild_every > 0 && self.refits + 1 >= rebuild_every {
            *self = Self::build(geometry, parameters, clock)?;
            return Ok(());
        }
        self.refits += 1;
        let scale = scale_for(geometry.diagonal());
        let triangles = gather(geometry, scale, clock);
        clock.host_phase("refit boxes", || refit(&mut self.bvh, &triangles));
        self.triangles = Leaves::new(&self.bvh, &triangles, parameters.triangle, clock);
        (self.scale, self.geometry) = (scale, geometry.clone());
        Ok(())
    }
}

/// What hears of a search's work.
trait Listener {
    /// A node is visited.
    fn node(&mut self, index: impl FnOnce() -> usize);
    /// The triangle of a slot is tested.
    fn test(&mut self, slot: usize);
}

/// Of the timed variant: nobody.
impl Listener for () {
    fn node(&mut self, _index: impl FnOnce() -> usize) {}
    fn test(&mut self, _slot: usize) {}
}

/// A bit a node and a slot: touched by any ray.
struct Touched {
    nodes: Vec<AtomicU32>,
    references: Vec<AtomicU32>,
}

impl Touched {
    fn new(nodes: usize, references: usize) -> Self {
        let bits = |count: usize| (0..count.div_ceil(32)).map(|_| AtomicU32::new(0)).collect();
        Self { nodes: bits(nodes), references: bits(references) }
    }

    fn count(words: Vec<AtomicU32>) -> u64 {
        words.into_iter().map(|word| u64::from(word.into_inner().count_ones())).sum()
    }
}

/// Counts of one ray.
struct Work<'a> {
    nodes: u64,
    tests: u64,
    touched: &'a Touched,
}

impl Listener for Work<'_> {
    fn node(&mut self, index: impl FnOnce() -> usize) {
        let index = index();
        self.nodes += 1;
        self.touched.nodes[index / 32].fetch_or(1 << (index % 32), Relaxed);
    }

    fn test(&mut self, slot: usize) {
        self.tests += 1;
        self.touched.references[slot / 32].fetch_or(1 << (slot % 32), Relaxed);
    }
}

/// obvhs's `Traversal`, with a stack of one's own choice.
struct Traversal<S> {
    stack: S,
    current_group: UVec2,
    primitive_group: UVec2,
    oct_inv4: u32,
    primitive_id: u32,
    hitmask: u32,
}

impl BvhCpuStructure {
    /// Closest hit or, with `any`, the first found. Equal t goes to the lower primitive. Listeners are types so that the
    /// timed variant has no counting in it.
    fn answer(&self, ray: &Ray, any: bool, listener: &mut impl Listener) -> Hit {
        let ray = ObvhsRay::new(
            Vec3A::from(ray.origin) * self.scale,
            // obvhs takes minus zero to rise and its inverse to fall: zeros get one sign.
            Vec3A::from(ray.direction) + 0.0,
            ray.t_min * self.scale,
            (ray.t_max * self.scale).min(f32::MAX),
        );
        match &self.triangles {
            Leaves::Edges(triangles) => self.answer_by(&triangles.as_slice(), ray, any, listener),
            Leaves::Corners(triangles) => {
                self.answer_by(&Watertight::new(triangles, &self.bvh.total_aabb, &ray), ray, any, listener)
            }
        }
    }

    fn answer_by(&self, test: &impl Test, ray: ObvhsRay, any: bool, listener: &mut impl Listener) -> Hit {
        if self.depth < STACK {
            self.search(test, ray, any, StackStack::<UVec2, STACK>::default(), listener)
        } else {
            self.search(test, ray, any, HeapStack::<UVec2>::new_with_capacity(self.depth + 1), listener)
        }
    }

    /// The surface of every hit.
    fn gather(&self, hits: &[Hit], surfaces: &mut [Surface]) {
        surfaces.par_chunks_mut(RAYS_PER_TASK).zip(hits.par_chunks(RAYS_PER_TASK)).for_each(|(surfaces, hits)| {
            for (surface, hit) in surfaces.iter_mut().zip(hits) {
                *surface = self.geometry.surface_of(hit);
            }
        });
    }

    fn search<S: FastStack<UVec2>>(
        &self,
        test: &impl Test,
        mut ray: ObvhsRay,
        any: bool,
        stack: S,
        listener: &mut impl Listener,
    ) -> Hit {
        let mut found: Option<(usize, u32)> = None;
        let start = self.bvh.new_traversal(ray.direction);
        let mut state = Traversal {
            stack,
            current_group: start.current_group,
            primitive_group: start.primitive_group,
            oct_inv4: start.oct_inv4,
            primitive_id: 0,
            hitmask: 0,
        };
        let mut node;
        'search: {
            obvhs::traverse!(
                self.bvh,
                node,
                state,
                {
                    listener.node(|| self.place(node));
                    test.children(node, &ray, state.oct_inv4)
                },
                {
                    let slot = state.primitive_id as usize;
                    listener.test(slot);
                    let t = test.t(slot, &ray);
                    if t <= ray.tmax {
                        let primitive = self.bvh.primitive_indices[slot];
                        if t < ray.tmax || found.is_none_or(|(_, best)| primitive < best) {
                            ray.tmax = t;
                            found = Some((slot, primitive));
                        }
                        if any {
                            break 'search;
                        }
                    }
                }
            );
        }
        match found {
            None => Hit::miss(Status::Miss),
            Some((slot, primitive)) => {
                let weights = test.weights(slot, &ray);
                Hit { t: ray.tmax / self.scale, primitive, u: weights.x, v: weights.y, status: Status::Hit as u32 }
            }
        }
    }

    /// The index of one of the nodes, of which a search sees no more than itself.
    fn place(&self, node: &CwBvhNode) -> usize {
        (std::ptr::from_ref(node).addr() - self.bvh.nodes.as_ptr().addr()) / size_of::<CwBvhNode>()
    }
}

impl Structure for BvhCpuStructure {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        _viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let parameters = &CpuParameters::try_from(parameters)?;
        match update {
            Update::Rebuild => *self = Self::build(geometry, parameters, clock)?,
            Update::Refit => self.refit(geometry, parameters, clock)?,
            Update::Reuse => {}
        }
        Ok(())
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        let any = job.rays.query == Query::Any;
        let count = job.rays.host.len();
        // What there is no room for is refused before the work.
        if job.trace_to == TraceTo::Surface {
            hits.host_surfaces_mut(count)?;
        }
        let found = hits.host_mut(count)?;
        clock.host_phase("traverse", || {
            found.par_chunks_mut(RAYS_PER_TASK).zip(job.rays.host.par_chunks(RAYS_PER_TASK)).for_each(
                |(hits, rays)| {
                    for (hit, ray) in hits.iter_mut().zip(rays) {
                        *hit = self.answer(ray, any, &mut ());
                    }
                },
            );
        });
        if job.trace_to == TraceTo::Surface {
            let (hits, surfaces) = hits.host_surfaces_mut(count)?;
            clock.host_phase("gather", || self.gather(hits, surfaces));
        }
        Ok(())
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let any = job.rays.query == Query::Any;
        let touched = Touched::new(self.bvh.nodes.len(), self.triangles.size()[2]);
        let answer = |ray: &Ray| {
            let mut work = Work { nodes: 0, tests: 0, touched: &touched };
            (self.answer(ray, any, &mut work), [work.nodes, work.tests])
        };
        let found: Vec<(Hit, [u64; 2])> = job.rays.host.par_iter().map(answer).collect();
        for (slot, (hit, _)) in hits.host_mut(found.len())?.iter_mut().zip(&found) {
            *slot = *hit;
        }
        if job.trace_to == TraceTo::Surface {
            let (hits, surfaces) = hits.host_surfaces_mut(found.len())?;
            self.gather(hits, surfaces);
        }
        Ok(vec![
            Counter::of("nodes_visited", found.iter().map(|(_, [nodes, _])| *nodes)),
            Counter::of("triangle_tests", found.iter().map(|(_, [_, tests])| *tests)),
            Counter::of_set("nodes_touched", Touched::count(touched.nodes)),
            Counter::of_set("references_touched", Touched::count(touched.references)),
        ])
    }

    fn memory(&self) -> MemoryReport {
        self.memory.clone()
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let depth = depth(&self.bvh)?;
        check_references(&self.bvh.primitive_indices, self.triangle_count, self.bvh.uses_spatial_splits)?;
        Ok(vec![
            ("nodes", self.bvh.nodes.len() as f64),
            ("depth", depth as f64),
            ("references", self.bvh.primitive_indices.len() as f64),
            ("sah_cost", sah::of_wide(&self.bvh)),
        ])
    }
}

#[cfg(test)]
mod tests;
