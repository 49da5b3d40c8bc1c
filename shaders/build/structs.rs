//! Structs that shaders bind, as Rust source: host code fills and reads what it binds by the types that shaders declare.

use std::fmt::Write as _;

use naga::{AddressSpace, ArraySize, Handle, Module, Scalar, ScalarKind, StructMember, Type, TypeInner};

/// A struct with its members as WGSL lays them out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoundStruct {
    pub name: String,
    /// The file that declares it.
    pub file: String,
    /// Name, offset in bytes and type of each, as Rust calls it.
    pub members: Vec<(String, u32, String)>,
    pub size: u32,
}

/// The Rust module of a file's folder.
pub fn module_of(file: &str) -> String {
    file.split('/').next().unwrap_or_default().replace('-', "_")
}

/// naga_oil appends the module's name, encoded, to every imported name.
pub fn plain(name: &Option<String>) -> String {
    name.as_deref().and_then(|name| name.split("X_naga_oil").next()).unwrap_or_default().to_owned()
}

/// Those of everything that a shader binds, and those in them. What Rust has no plain type for (atomics, matrices, arrays whose length
/// nobody says, bytes that no member names) is left out where it is storage. `file_of` tells which file declares a name.
///
/// # Errors
/// With the name of a uniform that Rust has no plain type for.
pub fn bound_structs(module: &Module, file_of: impl Fn(&str) -> String) -> Result<Vec<BoundStruct>, String> {
    let mut types = Types { module, file_of, found: Vec::new() };
    for (_, variable) in module.global_variables.iter() {
        let is_uniform = variable.space == AddressSpace::Uniform;
        if is_uniform || matches!(variable.space, AddressSpace::Storage { .. }) {
            let mut of = variable.ty;
            while let TypeInner::Array { base, .. } = module.types[of].inner {
                of = base;
            }
            if types.named(of).is_none() && is_uniform {
                return Err(format!("uniform {} has no plain type in Rust", plain(&variable.name)));
            }
        }
    }
    Ok(types.found)
}

struct Types<'a, Of> {
    module: &'a Module,
    file_of: Of,
    found: Vec<BoundStruct>,
}

impl<Of: Fn(&str) -> String> Types<'_, Of> {
    /// A type's name in Rust and its bytes; structs in it are put to those that are found.
    fn named(&mut self, of: Handle<Type>) -> Option<(String, u32)> {
        let scalar = |scalar: &Scalar| match scalar {
            Scalar { kind: ScalarKind::Uint, width: 4 } => Some("u32"),
            Scalar { kind: ScalarKind::Sint, width: 4 } => Some("i32"),
            Scalar { kind: ScalarKind::Float, width: 4 } => Some("f32"),
            _ => None,
        };
        let Type { name, inner } = &self.module.types[of];
        match inner {
            TypeInner::Scalar(each) => Some((scalar(each)?.to_owned(), 4)),
            TypeInner::Vector { size, scalar: each } => {
                let size = *size as u32;
                Some((format!("[{}; {size}]", scalar(each)?), 4 * size))
            }
            TypeInner::Array { base, size: ArraySize::Constant(count), stride } => {
                let (each, bytes) = self.named(*base)?;
                let whole = match self.module.types[*base].inner {
                    // Uniforms pack numbers into vectors.
                    TypeInner::Vector { size, scalar: each } => {
                        format!("[{}; {}]", scalar(&each)?, size as u32 * count.get())
                    }
                    _ => format!("[{each}; {count}]"),
                };
                (bytes == *stride).then_some((whole, bytes * count.get()))
            }
            TypeInner::Struct { members, span } => {
                let mut end = 0;
                let mut member = |member: &StructMember| {
                    let (of, bytes) = self.named(member.ty)?;
                    let begin = std::mem::replace(&mut end, member.offset + bytes);
                    (begin == member.offset).then(|| (plain(&member.name), member.offset, of))
                };
                let members = members.iter().map(&mut member).collect::<Option<Vec<_>>>()?;
                if end != *span {
                    return None;
                }
                let name = plain(name);
                let path = |file: &str| format!("super::{}::{name}", module_of(file));
                let file = (self.file_of)(&name);
                let whole = (path(&file), *span);
                let found = BoundStruct { name, file, members, size: *span };
                if !self.found.contains(&found) {
                    self.found.push(found);
                }
                Some(whole)
            }
            _ => None,
        }
    }
}

impl BoundStruct {
    /// The item. A build fails where Rust lays it out otherwise than WGSL.
    pub fn item(&self) -> String {
        let Self { name, file, members, size } = self;
        let (mut fields, mut checks) = (String::new(), String::new());
        for (member, offset, of) in members {
            let _ = writeln!(fields, "pub {member}: {of},");
            let _ = writeln!(checks, "assert!(std::mem::offset_of!({name}, {member}) == {offset});");
        }
        format!(
            "/// `{name}` of `{file}`.\n#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n#[repr(C)]\n\
             #[allow(missing_docs, reason = \"made of the shader, which documents it\")]\npub struct {name} {{\n{fields}}}\nconst _: () = \
             {{\n{checks}assert!(size_of::<{name}>() == {size});\n}};\n"
        )
    }

    /// Its line in the list of all, by what Rust has made of it.
    pub fn listed(&self) -> String {
        let path = format!("{}::{}", module_of(&self.file), self.name);
        let member =
            |(member, ..): &(String, u32, String)| format!("({member:?}, std::mem::offset_of!({path}, {member})), ");
        let members: String = self.members.iter().map(member).collect();
        format!("BoundStruct {{ name: {:?}, members: &[{members}], size: size_of::<{path}>() }},\n", self.name)
    }
}
