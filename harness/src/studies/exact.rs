//! Whether a tracer has any wrong ray: every ray set from five viewpoints of every scene.

use crate::plan::{Plan, ViewRequest};

/// From so many viewpoints a scene is seen.
const VIEWPOINTS: usize = 5;

/// A plan from each viewpoint: the scene's own cameras first, then others on the circle through its default one.
pub fn plans(plan: &Plan) -> Vec<Plan> {
    (0..VIEWPOINTS).map(|place| Plan { view: ViewRequest::Nth(place, VIEWPOINTS), ..plan.clone() }).collect()
}
