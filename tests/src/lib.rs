//! What the tests across crates share: the device, tiny scenes, seeded numbers.

mod asked;
mod fake;
pub mod fuzz;

use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::io::Write as _;
use std::sync::{Arc, Mutex};

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    AdapterChoice, DeviceLimits, Geometry, Gpu, ParameterDescription, Parameters, Preset, Ray, Tracer, TracerError,
    Viewpoint, wgpu,
};

pub use asked::{answers, counted, gpu_that_binds, parameters, total};
pub use fake::{Fake, Manner};

/// A device for the calling test. Tests run side by side and a device's clock serves one sample at a time, so each
/// thread has its own.
///
/// # Panics
/// Without an adapter: these tests cannot vouch for device code on a machine that runs none of it.
pub fn gpu() -> Arc<Gpu> {
    thread_local! {
        static GPU: OnceCell<Arc<Gpu>> = const { OnceCell::new() };
    }
    let choice = AdapterChoice::from_environment(None, None);
    let open = || match choice.and_then(|choice| Gpu::open(&choice)) {
        Ok(gpu) => Arc::new(gpu),
        Err(error) => {
            panic!("this test needs a graphics adapter, software or hardware; setup.sh installs one: {error}")
        }
    };
    GPU.with(|gpu| Arc::clone(gpu.get_or_init(open)))
}

/// Whether the adapter of a device has ray queries, within the limits that were chosen: asked of the adapter itself, not of the device
/// that was opened on it.
pub fn adapter_has_ray_queries(gpu: &Gpu) -> bool {
    if gpu.listing.limits == DeviceLimits::Webgpu {
        return false;
    }
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let adapters = pollster::block_on(instance.enumerate_adapters(backends));
    let listing = &gpu.listing;
    let same = |adapter: &&wgpu::Adapter| {
        let info = adapter.get_info();
        info.name == listing.name
            && info.driver_info == listing.driver_version
            && info.backend.to_string() == listing.backend
    };
    adapters
        .iter()
        .find(same)
        .is_some_and(|adapter| adapter.features().contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY))
}

/// A tracer as its constructor gave it, or nothing where the adapter cannot run it; that is said on standard error, past
/// the capture of the test runner, once a process and reason.
///
/// # Panics
/// If it could not be created for another reason than that the adapter has no ray queries, or that WebGPU's limits forbid it.
pub fn available(name: &str, created: Result<Box<dyn Tracer>, TracerError>, gpu: &Gpu) -> Option<Box<dyn Tracer>> {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let reason = match created {
        Ok(tracer) => return Some(tracer),
        Err(TracerError::Unavailable(reason)) => reason,
        Err(error) => panic!("{name}: {error}"),
    };
    assert!(reason.contains(&gpu.listing.name), "{name}: {reason}");
    if gpu.listing.limits == DeviceLimits::Adapter {
        assert!(reason.contains("no ray queries"), "{name}: {reason}");
        assert!(!adapter_has_ray_queries(gpu), "{name} says '{reason}', but the adapter has ray queries");
    }
    let skipped = format!("skipped {name}: {reason}");
    if SAID.lock().is_ok_and(|mut said| said.insert(skipped.clone())) {
        let _ = writeln!(std::io::stderr(), "{skipped}");
    }
    None
}

/// The presets of a tracer with their parameters; one with the values of another before it is that one, and left out.
pub fn presets(described: &[ParameterDescription]) -> Vec<(Preset, Parameters)> {
    let mut found: Vec<(Preset, Parameters)> = Vec::new();
    for preset in Preset::ALL {
        let parameters = Parameters::preset(described, preset);
        if found.iter().all(|(_, other)| *other != parameters) {
            found.push((preset, parameters));
        }
    }
    found
}

/// A generator of numbers that are the same on every machine (SplitMix64).
#[derive(Clone, Debug)]
pub struct Numbers(u64);

impl Numbers {
    /// Numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A real number in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A real number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        f64::midpoint(self.signed(), 1.0)
    }

    /// A point in the cube [-1, 1)^3.
    pub fn point(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    /// A unit vector, evenly spread.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let point = self.point();
            if (0.01..1.0).contains(&point.length()) {
                return point.normalize();
            }
        }
    }
}

/// A viewpoint at `eye` that looks at `target` with y up.
pub fn viewpoint(eye: Vec3, target: Vec3, near: f32, far: f32, frame: [u32; 2]) -> Viewpoint {
    let forward = (target - eye).normalize();
    let right = forward.cross(if forward.y.abs() < 0.99 { Vec3::Y } else { Vec3::Z }).normalize();
    Viewpoint { eye, forward, up: right.cross(forward).normalize(), vertical_fov: 1.0, near, far, frame, face: 16 }
}

/// A ray with a unit direction, without an end.
pub fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray {
        origin: origin.as_vec3().into(),
        t_min: 0.0,
        direction: direction.normalize().as_vec3().into(),
        t_max: Ray::UNBOUNDED,
    }
}

/// The same rays from one point: for tracers that serve no others.
pub fn from_one_point(rays: &[Ray], origin: [f32; 3]) -> Vec<Ray> {
    rays.iter().map(|ray| Ray { origin, ..*ray }).collect()
}

/// Geometry of triangles that share no vertices, on the device as well if there is one.
///
/// # Panics
/// If the device cannot hold it.
pub fn soup(triangles: &[[[f32; 3]; 3]], gpu: Option<&Gpu>) -> Geometry {
    let indices = (0..triangles.len() as u32).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
    match Geometry::new(triangles.as_flattened().to_vec(), indices, gpu) {
        Ok(geometry) => geometry,
        Err(error) => panic!("the test's scene was refused: {error}"),
    }
}

/// A rectangle as two triangles: `corner`, and the two edges that start there.
pub fn rectangle(corner: [f32; 3], first: [f32; 3], second: [f32; 3]) -> [[[f32; 3]; 3]; 2] {
    let at = |a: f32, b: f32| std::array::from_fn(|axis| corner[axis] + a * first[axis] + b * second[axis]);
    [[at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)], [at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]]
}
