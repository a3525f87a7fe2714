//! What all accepted windows say in sum, kept while they come.

use crate::side::Side;
use interfaces::ScalarKind;
use interfaces::port::names;
use output::columns::Column;
use output::summary::{Condition46, EnergyBalance, Extremes, FluidBalance};
use output::sums::{Energies, EnergySum, ResidualSum};
use std::collections::BTreeMap;
use words::bytes::{self, Reader, Writer};

/// The sums so far.
#[derive(Debug, Default)]
pub(super) struct Running {
    energy: Option<EnergySum>,
    before: ResidualSum,
    after: ResidualSum,
    fluid: Option<FluidBalance>,
    /// Of each probe's column, in the table's order.
    probes: Vec<(String, Option<Extremes>)>,
}

impl Running {
    /// Sums over nothing, of probes with these columns.
    pub(super) fn new(probes: &[Column]) -> Self {
        let probes = probes.iter().map(|column| (column.name.clone(), None)).collect();
        Self { probes, ..Self::default() }
    }

    /// The residuals of condition (46) in one more window.
    pub(super) fn condition_46(&mut self, before: f64, after: f64) {
        self.before.add(before);
        self.after.add(after);
    }

    /// What the sides report of one more window: every energy, and the fluid's volume and particles.
    pub(super) fn balances(&mut self, sides: &[&Side]) {
        let (mut energies, mut any) = (Energies::default(), false);
        for side in sides {
            for name in names::ENERGIES {
                any |= reported(side, name).is_some_and(|value| energies.add(name, value));
            }
        }
        match &mut self.energy {
            Some(sum) if any => sum.add(energies),
            none if any => *none = Some(EnergySum::new(energies)),
            _ => {}
        }
        for side in sides.iter().filter(|side| side.role() == interfaces::Role::Fluid) {
            let Some(drift) = reported(side, names::VOLUME_DRIFT) else { continue };
            let count = |name| reported(side, name).map_or(0, |value| value as u64);
            let fluid = self.fluid.get_or_insert_default();
            if drift.abs() > fluid.volume_drift.abs() {
                fluid.volume_drift = drift;
            }
            fluid.particles_lost = count(names::PARTICLES_LOST);
            fluid.particles_left = count(names::PARTICLES_LEFT);
        }
    }

    /// The probes' values at a time (s).
    pub(super) fn probes(&mut self, time: f64, values: &[f64]) {
        let columns = self.probes.iter_mut().zip(values);
        columns.for_each(|((_, found), value)| Extremes::extend(found, time, *value));
    }

    pub(super) fn energy(&self) -> Option<EnergyBalance> {
        self.energy.as_ref().map(EnergyBalance::from)
    }

    pub(super) fn spreads(&self) -> Condition46 {
        Condition46 { before: (&self.before).into(), after: (&self.after).into() }
    }

    pub(super) fn fluid(&self) -> Option<FluidBalance> {
        self.fluid.clone()
    }

    pub(super) fn extremes(&self) -> BTreeMap<String, Extremes> {
        self.probes.iter().filter_map(|(name, found)| Some((name.clone(), found.clone()?))).collect()
    }

    pub(super) fn save(&self, state: &mut Writer) {
        let energy = self.energy.map(|EnergySum { start, end, lowest, rise, least, most }| {
            let of = |e: Energies| [e.kinetic, e.potential, e.strain];
            [&[start, end, lowest, rise][..], &of(least), &of(most)].concat()
        });
        state.f64s(energy.as_ref().map_or(&[][..], |sums| sums));
        for ResidualSum { max, squares, count } in [self.before, self.after] {
            state.f64s(&[max, squares, count]);
        }
        let fluid = self.fluid.as_ref();
        let fluid = fluid.map(|f| [f.volume_drift, f.particles_lost as f64, f.particles_left as f64]);
        state.f64s(fluid.as_ref().map_or(&[][..], |sums| sums));
        state.list(&self.probes, |state, (name, found)| {
            state.text(name);
            let found = found.as_ref().map(|f| [f.max, f.max_time, f.min, f.min_time]);
            state.f64s(found.as_ref().map_or(&[][..], |found| found));
        });
    }

    pub(super) fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        let energy = state.f64s("energy", None)?;
        self.energy = match energy[..] {
            [start, end, lowest, rise, k, p, s, most_k, most_p, most_s] => Some(EnergySum {
                start,
                end,
                lowest,
                rise,
                least: Energies { kinetic: k, potential: p, strain: s },
                most: Energies { kinetic: most_k, potential: most_p, strain: most_s },
            }),
            _ => None,
        };
        for sum in [&mut self.before, &mut self.after] {
            let found = state.f64s("residuals", Some(3))?;
            *sum = ResidualSum { max: found[0], squares: found[1], count: found[2] };
        }
        let fluid = state.f64s("volume and particles", None)?;
        self.fluid = match fluid[..] {
            [volume_drift, lost, left] => Some(FluidBalance {
                volume_drift,
                particles_lost: lost as u64,
                particles_left: left as u64,
                ..FluidBalance::default()
            }),
            _ => None,
        };
        self.probes = state.list("extremes of probes", None, |state| {
            let name = state.text("probe")?.to_owned();
            let found = state.f64s("extremes", None)?;
            let found = match found[..] {
                [max, max_time, min, min_time] => Some(Extremes { max, max_time, min, min_time }),
                _ => None,
            };
            Ok((name, found))
        })?;
        Ok(())
    }
}

fn reported(side: &Side, name: &str) -> Option<f64> {
    let described = side.describe().scalars.iter().zip(&side.scalars);
    let mut balances = described.filter(|(scalar, _)| scalar.kind == ScalarKind::Balance);
    balances.find(|(scalar, _)| scalar.name == name).map(|(_, value)| *value)
}
