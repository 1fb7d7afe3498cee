//! How far a robot gets with what is left in its battery, and when it must ask for a charge.

use protocol::EnergyJ;

/// The reach of a robot in cells (LMPP d_l, eq. 6): the energy it has over the energy that a
/// cell takes. 0 if a cell takes no positive, finite energy, so that an impossible robot is
/// sent nowhere.
#[must_use]
pub fn reach_cells(energy: EnergyJ, energy_per_metre_j: f64, resolution_m: f64) -> f64 {
    let energy_per_cell_j = energy_per_metre_j * resolution_m;
    let reach = f64::from(energy.get()) / energy_per_cell_j;
    if energy_per_cell_j > 0.0 && reach.is_finite() { reach } else { 0.0 }
}

/// The energy at which a robot must ask for a charge (LMPP g_alert, eq. 3): enough for a drive
/// through the whole of the site, `diameter_m` long, and `reserve` (delta) on top.
#[must_use]
pub fn alert_energy(energy_per_metre_j: f32, diameter_m: f64, reserve: EnergyJ) -> EnergyJ {
    let drive_j = f64::from(energy_per_metre_j) * diameter_m;
    EnergyJ::clamped((drive_j + f64::from(reserve.get())) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joules(value: f32) -> EnergyJ {
        EnergyJ::new(value).unwrap()
    }

    #[test]
    fn the_reach_is_the_energy_over_what_a_cell_takes() {
        assert_eq!(reach_cells(joules(1000.0), 20.0, 0.5), 100.0);
        assert_eq!(reach_cells(joules(0.0), 20.0, 0.5), 0.0);
    }

    #[test]
    fn a_robot_that_claims_to_drive_for_nothing_has_no_reach() {
        for impossible in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(reach_cells(joules(1000.0), impossible, 1.0), 0.0, "{impossible}");
        }
        assert_eq!(reach_cells(joules(1000.0), 20.0, f64::NAN), 0.0);
    }

    #[test]
    fn the_alert_leaves_enough_to_cross_the_site_and_the_reserve() {
        assert_eq!(alert_energy(20.0, 140.0, joules(200.0)), joules(3000.0));
        assert_eq!(alert_energy(f32::NAN, 140.0, joules(200.0)), EnergyJ::MIN);
    }
}
