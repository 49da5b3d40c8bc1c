//! Scenes so far from the origin that f32 leaves few places for their vertices.

/// With fewer steps of f32 across the scene than these its import says so: one is more than a hundredth of a thousandth of it.
const FEW_STEPS: f64 = 65_536.0;

/// Steps of f32 across a scene's diagonal, where its coordinates are greatest.
fn steps_across(diagonal: f64, greatest: f64) -> f64 {
    let greatest = greatest.abs().max(f64::from(f32::MIN_POSITIVE)) as f32;
    diagonal / (f64::from(greatest.next_up()) - f64::from(greatest))
}

/// Whether a scene is so far from the origin that methods which compare positions may not find their own triangles again.
pub fn is_far(diagonal: f64, greatest: f64) -> bool {
    steps_across(diagonal, greatest) < FEW_STEPS
}

/// A word on a scene that is far away.
pub(super) fn warning(diagonal: f64, greatest: f64) -> Option<String> {
    is_far(diagonal, greatest).then(|| {
        format!(
            "the scene reaches {greatest:.3e} from the origin and is {diagonal:.3e} across: positions in f32 keep only {:.0} steps \
             across it, so shapes are coarse and some tracers refuse it; move it towards the origin",
            steps_across(diagonal, greatest)
        )
    })
}
