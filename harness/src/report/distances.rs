//! What a summary says of how far told hits are from the mesh, of sets that a tracer with images along axes answers: its texels are
//! the measure that such a method is built for.

use super::cells::{Row, label};
use super::format::{NONE, optional, percent, significant, thousands};
use super::group::Role;
use super::markdown::Table;
use super::metrics;
use crate::results::{PieceDistance, SurfaceDistance};

/// Pieces of mesh that a table shows of each tracer.
const SHOWN_PIECES: usize = 6;

/// Every table; nothing where no tracer has texels of its own.
pub(super) fn tables(rows: &[Row<'_>]) -> String {
    let told: Vec<(&Row<'_>, &SurfaceDistance)> = rows
        .iter()
        .filter(|row| row.0 == Role::Contender)
        .filter_map(|row| Some((row, metrics::distance(row.2)?)))
        .collect();
    if told.iter().all(|(_, told)| told.own_texel.is_none()) {
        return String::new();
    }
    let mut table = Table::new(&[
        "tracer".to_owned(),
        "rays with a true hit".to_owned(),
        metrics::WITHIN_TEXEL.heading(),
        metrics::WITHIN_OWN_TEXEL.heading(),
        "its texel (scene units)".to_owned(),
        "distance p50 / p95 / p99 (scene units) ↓".to_owned(),
    ]);
    for ((role, run, _), told) in &told {
        let share = |share: Option<f64>| {
            share.map_or_else(|| NONE.to_owned(), |share| format!("{} %", percent(share, told.rays)))
        };
        let distance = told.distance;
        table.row(&[
            label(*role, run),
            thousands(told.rays),
            share(told.within_common_texel),
            share(told.within_own_texel),
            optional(told.own_texel, 3),
            format!("{} / {} / {}", optional(distance.p50, 3), optional(distance.p95, 3), optional(distance.p99, 3)),
        ]);
    }
    let common = told.first().map_or(0.0, |(_, told)| told.common_texel);
    format!(
        "\nTold hits by their distance from the connected piece of mesh that is truly hit; a common texel is {} scene units:\n\n{}{}",
        significant(common, 3),
        table.text,
        pieces(&told)
    )
}

/// The pieces that have the most rays, of tracers with texels of their own.
fn pieces(told: &[(&Row<'_>, &SurfaceDistance)]) -> String {
    let mut table = Table::new(
        &[
            "tracer",
            "piece (first triangle)",
            "triangles",
            "mean thickness (scene units)",
            "rays",
            "within its own texel ↑",
            "rays that hit other pieces ↑",
        ]
        .map(str::to_owned),
    );
    let own = told.iter().filter(|(_, told)| told.own_texel.is_some());
    for ((role, run, _), told) in own {
        let thickness =
            |piece: &PieceDistance| if piece.open { "open".to_owned() } else { optional(piece.mean_thickness, 3) };
        let share = |within: Option<f64>, rays: u64| {
            let share = within.filter(|_| rays > 0).map(|within| within / rays as f64);
            share.map_or_else(|| NONE.to_owned(), |share| format!("{} %", percent(share, rays)))
        };
        let within_all = told.within_own_texel.map(|share| (share * told.rays as f64).round());
        for piece in told.pieces.iter().take(SHOWN_PIECES) {
            let within = piece.within_own_texel_rays.map(|within| within as f64);
            let within_others = within_all.zip(within).map(|(all, within)| all - within);
            table.row(&[
                label(*role, run),
                thousands(u64::from(piece.first_triangle)),
                thousands(piece.triangles),
                thickness(piece),
                thousands(piece.rays),
                share(within, piece.rays),
                share(within_others, told.rays - piece.rays),
            ]);
        }
    }
    format!("\nThe pieces of mesh that most rays truly hit, and what is left without each:\n\n{}", table.text)
}
