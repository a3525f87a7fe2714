//! What crosses an area: the particles whose way in a step leads through it.

use crate::boundaries::period::Period;
use crate::particles::state::State;
use crate::probes::area::Area;
use sph::Vector;
use words::rigid::Pose;

/// Net number of particles that cross an area in a step from `before` to `after`, each by the straight way
/// between its two places, those towards the side to which the area looks less those against it. Of an area
/// that moves, `poses` are where it has come before and after the step, and ways are those seen from it.
/// Particles that leave the run in the step do not count. `places` is memory.
pub fn crossings<const D: usize, M>(
    area: &Area<D>,
    (before, after): (&State<D, M>, &State<D, M>),
    poses: Option<&[Pose<D>; 2]>,
    period: &Period<D>,
    places: &mut Vec<u32>,
) -> f64 {
    const NOWHERE: u32 = u32::MAX;
    places.clear();
    places.resize(after.ids.iter().max().map_or(0, |most| *most as usize + 1), NOWHERE);
    after.ids.iter().zip(0u32..).for_each(|(id, place)| places[*id as usize] = place);
    let way = |from: Vector<D>, to: Vector<D>| match poses {
        Some([start, end]) => area.crossing(&start.at_rest(&from), &end.at_rest(&to)),
        None => area.crossing(&from, &to),
    };
    let mut net = 0.0;
    for (id, from) in before.ids.iter().zip(&before.positions) {
        let place = places.get(*id as usize).copied().unwrap_or(NOWHERE);
        let Some(to) = after.positions.get(place as usize) else { continue };
        let step = period.nearest(to - from);
        net += way(*from, from + step);
        // Through a periodic side it comes in as its image does.
        if step != to - from && !period.is_none() {
            net += way(to - step, *to);
        }
    }
    net
}

#[cfg(test)]
mod tests {
    use super::*;
    use words::motion::Law;
    use words::rigid::Motion;

    type V = Vector<2>;

    fn state(positions: &[V]) -> State<2, ()> {
        State::at_start(positions.to_vec(), vec![V::zeros(); positions.len()], ())
    }

    fn count(area: &Area<2>, from: &State<2, ()>, to: &State<2, ()>) -> f64 {
        crossings(area, (from, to), None, &Period::default(), &mut Vec::new())
    }

    /// A lattice of 40 × 40 cells drifts by 0.3 spacings a step, 100 steps long: 30 columns of those 20
    /// particles pass that are as high as the segment. Rearranged and thinned, the particles are the same.
    #[test]
    fn a_lattice_that_drifts_through_a_segment_is_counted_to_the_particle() {
        let lattice: Vec<V> =
            (0..1600).map(|i| V::from([f64::from(i % 40) + 0.5, f64::from(i / 40) + 0.5])).collect();
        let area = Area::of_edges(V::from([40.0, 20.0]), &[V::from([0.0, 20.0])], Some(&V::new(1.0, 0.0)));
        let area = area.unwrap();
        let (mut before, mut net) = (state(&lattice), 0.0);
        for step in 1..=100 {
            let mut after = state(&lattice);
            after.positions.iter_mut().for_each(|r| r.x += 0.3 * f64::from(step));
            if step % 2 == 0 {
                after.ids.reverse();
                after.positions.reverse();
            }
            net += count(&area, &before, &after);
            before = after;
        }
        assert_eq!(net, 30.0 * 20.0);
        // All the way back at once.
        assert_eq!(count(&area, &before, &state(&lattice)), -600.0);
        let mut fewer = state(&lattice);
        fewer.ids.truncate(800);
        fewer.positions.truncate(800);
        assert_eq!(count(&area, &before, &fewer), -300.0, "the upper half has left the run");
    }

    #[test]
    fn an_area_that_goes_along_is_not_crossed() {
        let law = Law::Table { table: vec![[0.0, 0.0], [1.0, 2.0]] };
        let motion = Motion::<2>::along([1.0, 0.0], law);
        let poses = [motion.pose(0.0), motion.pose(1.0)];
        let area = Area::of_edges(V::from([1.0, 0.0]), &[V::from([0.0, 1.0])], None).unwrap();
        let from = state(&[V::from([0.5, 0.0])]);
        let net = |x: f64, poses: Option<&[Pose<2>; 2]>| {
            let to = state(&[V::from([x, 0.0])]);
            crossings(&area, (&from, &to), poses, &Period::default(), &mut Vec::new()).abs()
        };
        // The area goes from x = 1 to 3.
        for (x, expected) in [(2.5, 0.0), (0.5, 0.0), (0.4, 0.0), (2.9, 0.0), (3.1, 1.0)] {
            assert_eq!(net(x, Some(&poses)), expected, "{x}");
        }
        assert_eq!(net(2.5, None), 1.0);
    }

    /// From x = 0.9 by 0.3 to 0.2, through the side at x = 1: past 0.95 and 0.1, and not back through all.
    #[test]
    fn ways_lead_through_periodic_sides() {
        let period = Period::new(&[true, false], &(V::zeros(), V::from([1.0, 1.0])));
        let (from, to) = (state(&[V::from([0.9, 0.5])]), state(&[V::from([0.2, 0.5])]));
        for (x, expected) in [(0.95, 1.0), (0.1, 1.0), (0.5, 0.0), (0.85, 0.0), (0.25, 0.0)] {
            let area = Area::of_edges(V::from([x, 0.5]), &[V::from([0.0, 0.4])], Some(&V::from([1.0, 0.0])));
            let net = crossings(&area.unwrap(), (&from, &to), None, &period, &mut Vec::new());
            assert_eq!(net, expected, "at {x}");
        }
    }
}
