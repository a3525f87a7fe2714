//! Weights made anew are what fresh ones would be, whatever was before and however many threads make them.

use super::*;

#[test]
fn updating_gives_what_building_gives_to_the_bit() {
    let random = &mut Random(31);
    let (cloud, follower) = (random.cloud(500, &[1.0, 1.0]), random.cloud(400, &[1.0, 1.0]));
    let swirl = |x: f64, y: f64| [x + 0.2 * (5.0 * y).sin(), y + 0.1 * x];
    for method in [Method::NearestNeighbour, Method::NearestNeighbourGradient, radial_basis()] {
        let mut mapping = build(2, method.clone(), &cloud, &follower);
        // Other numbers of points, too.
        mapping.update(&cloud[..200], &follower[..100]).unwrap();
        mapping.update(&moved(&cloud, swirl), &moved(&follower, swirl)).unwrap();
        assert_eq!(
            mapping.weights(),
            build(2, method.clone(), &moved(&cloud, swirl), &moved(&follower, swirl)).weights()
        );
        // What cannot be mapped leaves the mapping as it was: found at once, or at the last target.
        let before = mapping.weights().to_owned();
        assert!(mapping.update(&cloud, &[f64::NAN, 0.0]).is_err());
        if method != Method::NearestNeighbour {
            assert!(mapping.update(&[0.0, 0.0, 1.0, 1.0], &[0.0, 0.0, 0.5, 0.0]).is_err());
        }
        assert_eq!(mapping.weights(), before.view());
    }
    let (flat, facets) = outline([1.0, 0.05], [60, 3]);
    let inside = lattice(&[1.0, 0.05], &[80, 4]);
    let bend = |x: f64, y: f64| [x, y + 0.3 * x * x];
    let method = Method::NearestProjection { facets };
    let mut mapping = build(2, method.clone(), &flat, &inside);
    mapping.update(&moved(&flat, bend), &moved(&inside, bend)).unwrap();
    assert_eq!(mapping.weights(), build(2, method, &moved(&flat, bend), &moved(&inside, bend)).weights());
}

/// What a rebuilt mapping is does not depend on what it was: drifts, jumps, other numbers of points, flat
/// sets and sets that are refused, in any order.
#[test]
fn a_rebuilt_mapping_has_no_history() {
    let random = &mut Random(41);
    let (flat, facets) = outline([1.0, 0.2], [40, 8]);
    let methods = [
        Method::NearestNeighbour,
        Method::NearestNeighbourGradient,
        radial_basis(),
        Method::NearestProjection { facets },
    ];
    for method in methods {
        let boundary = matches!(method, Method::NearestProjection { .. });
        let cloud = if boundary { flat.clone() } else { random.cloud(1200, &[1.0, 0.2]) };
        let inside = random.cloud(1300, &[1.0, 0.2]);
        let (mut source, mut target) = (cloud.clone(), inside.clone());
        let settings = Settings { reach: 2.0, ..settings(2, method) };
        let mut mapping = Mapping::build(settings.clone(), &source, &target).expect("a plate");
        let mut refused = 0;
        for step in 0..40 {
            let [a, b, c] = [0; 3].map(|_| 2.0 * random.next() - 1.0);
            let kind = (5.0 * random.next()) as usize;
            let motion = move |x: f64, y: f64| match kind {
                // A drift, a finite bending, a jump far away, a plate pressed flat, a sheet folded onto
                // itself.
                0 => [x + 1e-4 * a * y, y + 1e-4 * b * x],
                1 => [x + 0.1 * a * y, y + 0.3 * b * x * x],
                2 => [x + 1e3 * a, y - 1e3 * b],
                3 => [x, 1e-9 * y],
                _ => [x, y - c * x.abs()],
            };
            (source, target) = (moved(&source, motion), moved(&target, motion));
            // Targets shuffled or fewer, or a source on another, now and then.
            if step % 7 == 3 {
                target = random.cloud(100 + 300 * (step % 5), &[1.0, 0.2]);
                source.clone_from(&cloud);
            } else if step % 11 == 5 && !boundary {
                source.truncate(2 * 600);
                let twin = [source[0], source[1]];
                source[200..202].copy_from_slice(&twin);
            } else if step % 5 == 4 {
                (source, target) = (cloud.clone(), inside.clone());
            }
            mapping.use_threads(1 + step % 3);
            match (mapping.update(&source, &target), Mapping::build(settings.clone(), &source, &target)) {
                (Ok(()), Ok(fresh)) => assert_eq!(mapping.weights(), fresh.weights(), "step {step}"),
                (Err(one), Err(other)) => {
                    assert_eq!(one, other, "step {step}");
                    refused += 1;
                }
                (updated, built) => panic!("step {step}: {updated:?}, {:?}", built.map(drop)),
            }
        }
        assert!(refused < 36, "{refused} of 40 were refused: nothing was compared");
    }
}

#[test]
fn weights_do_not_depend_on_the_number_of_threads() {
    let random = &mut Random(5);
    let (vertices, facets) = outline([1.0, 0.1], [60, 6]);
    let cloud = random.cloud(1500, &[1.0, 0.1]);
    // Enough for three threads to be started.
    let inside = random.cloud(3500, &[1.0, 0.1]);
    for (method, source) in [
        (Method::NearestNeighbourGradient, &cloud),
        (radial_basis(), &cloud),
        (Method::NearestProjection { facets }, &vertices),
    ] {
        let settings = Settings { reach: 0.5, ..settings(2, method) };
        let mut mapping = Mapping::build(settings, source, &inside).expect("a plate");
        let alone = mapping.weights().to_owned();
        for threads in [2, 3, 8] {
            mapping.use_threads(threads);
            mapping.update(source, &inside).unwrap();
            assert_eq!(mapping.weights(), alone.view(), "{threads} threads");
        }
        // The target that is named is the first that cannot be mapped, whichever part it is in.
        let mut lost = inside.clone();
        (lost[4001], lost[6001]) = (1e3, 1e3);
        let refused = mapping.update(source, &lost).unwrap_err();
        assert!(matches!(refused, MappingError::OutOfReach { point: 2000, .. }), "{refused}");
    }
}
