//! What the entry points of a shader need of a device, for limits to be asked before a pipeline is made.

use naga::valid::ModuleInfo;
use naga::{AddressSpace, GlobalVariable, Handle, ImageClass, Module, ShaderStage, TypeInner};

/// What one entry point binds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryNeeds {
    pub name: String,
    pub storage_buffers: u32,
    pub storage_textures: u32,
    /// Invocations of a workgroup; 0 of a stage that has none.
    pub invocations: u32,
}

/// Those of every entry point.
pub fn needs_of(module: &Module, info: &ModuleInfo) -> Vec<EntryNeeds> {
    let entries = module.entry_points.iter().enumerate();
    let needs = entries.map(|(index, entry)| {
        let used = |handle: Handle<GlobalVariable>| !info.get_entry_point(index)[handle].is_empty();
        let bound = module.global_variables.iter().filter(|(handle, _)| used(*handle));
        let bound: Vec<_> = bound.map(|(_, variable)| (variable.space, &module.types[variable.ty].inner)).collect();
        let is_texture =
            |inner: &TypeInner| matches!(inner, TypeInner::Image { class: ImageClass::Storage { .. }, .. });
        let buffers = bound.iter().filter(|(space, _)| matches!(space, AddressSpace::Storage { .. }));
        let invocations = if entry.stage == ShaderStage::Compute { entry.workgroup_size.iter().product() } else { 0 };
        EntryNeeds {
            name: entry.name.clone(),
            storage_buffers: buffers.count() as u32,
            storage_textures: bound.iter().filter(|(_, inner)| is_texture(inner)).count() as u32,
            invocations,
        }
    });
    needs.collect()
}
