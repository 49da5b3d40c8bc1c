//! Layouts of the structs that Rust and shaders share, as data: a test holds each against the shaders that have it.

use crate::{Hit, Ray, Surface};

/// A struct as shaders must lay it out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedLayout {
    /// Its name in WGSL; of all shared structs in one shader there is one of that name.
    pub name: &'static str,
    /// Its members in order, with their offsets in bytes.
    pub members: Vec<(&'static str, usize)>,
    /// Its bytes.
    pub size: usize,
}

/// Lists structs with all of their members, as a vector of [`SharedLayout`]s; `as` gives the name in WGSL where that is
/// another. A member that is left out does not compile.
///
/// ```
/// #[repr(C)]
/// struct Pass { count: u32, shift: u32 }
///
/// let layouts = tracebench_api::layouts! { Pass as SortPass { count, shift } };
/// assert_eq!((layouts[0].name, layouts[0].size), ("SortPass", 8));
/// assert_eq!(layouts[0].members, [("count", 0), ("shift", 4)]);
/// ```
///
/// ```compile_fail,E0027
/// #[repr(C)]
/// struct Pass { count: u32, shift: u32 }
///
/// let layouts = tracebench_api::layouts! { Pass as SortPass { count } };
/// ```
#[macro_export]
macro_rules! layouts {
    (@name $Type:ident) => { stringify!($Type) };
    (@name $Type:ident $Wgsl:ident) => { stringify!($Wgsl) };
    ($($Type:ident $(as $Wgsl:ident)? { $($member:ident),+ $(,)? })+) => {
        vec![$({
            let _whole = |shared: &$Type| { let $Type { $($member: _),+ } = shared; };
            $crate::SharedLayout {
                name: $crate::layouts!(@name $Type $($Wgsl)?),
                members: vec![$((stringify!($member), std::mem::offset_of!($Type, $member))),+],
                size: size_of::<$Type>(),
            }
        }),+]
    };
}

/// Layouts of the contract's own structs.
pub fn layouts() -> Vec<SharedLayout> {
    layouts! {
        Ray { origin, t_min, direction, t_max }
        Hit { t, primitive, u, v, status }
        Surface { position, material, normal, status }
    }
}
