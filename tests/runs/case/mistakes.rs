//! Every mistake has its line, key, value, problem and remedy.

use super::*;

/// One row a mistake: a passage of the sound case, what it is changed into, and the whole message.
#[rustfmt::skip]
const ROWS: &[(&str, &str, &str)] = &[
    // Keys and types.
    ("density = 1000.0",
     "densty = 1000.0",
     "line 10: fluid.densty = 1000.0: there is no such key; did you mean \"density\"?"),
    ("density = 1000.0",
     "density = 1000.0\nsmoothing_ratio = 0.1",
     "line 11: fluid.smoothing_ratio = 0.1: there is no such key; there is fluid.numerics.smoothing_ratio and structure.numerics.smoothing_ratio"),
    ("density = 1000.0\n", "", "line 9: fluid.density: is missing; add it; its meaning: density (kg/m³)"),
    ("[[fluid.region]]\nname = \"water\"\n",
     "[[fluid.region]]\n",
     "line 14: fluid.region.0.name: is missing; add it; its meaning: name"),
    ("1e-6",
     "\"thin\"",
     "line 11: fluid.kinematic_viscosity = \"thin\": is a string, but must be a number; its meaning: kinematic viscosity (m²/s)"),
    ("dimension = 2",
     "dimension = 2.0",
     "line 3: case.dimension = 2.0: is a number, but must be a whole number; its meaning: space dimension, 2 or 3"),
    ("dimension = 2",
     "dimension = 4",
     "line 3: case.dimension = 4: must be 2 or 3; its meaning: space dimension, 2 or 3"),
    ("[0.0, -9.81]",
     "-9.81",
     "line 6: case.gravity = -9.81: is a number, but must be a list of numbers; its meaning: acceleration of gravity on fluid and structure (m/s²); none if left out"),
    ("[0.0, -9.81]",
     "[0.0, \"down\"]",
     "line 6: case.gravity.1 = \"down\": is a string, but must be a number; its meaning: acceleration of gravity on fluid and structure (m/s²); none if left out"),
    ("[[0.0, 0.0], [0.01, 1.0]]",
     "[[0.0, 0.0, 1.0]]",
     "line 47: structure.load.0.ramp.0 = [0.0, 0.0, 1.0]: has 3 elements, but must have 2; its meaning: pairs of time (s) and factor of the force, linear between; the full force from the start if left out"),
    ("\"saint-venant-kirchhoff\"",
     "\"granite\"",
     "line 28: structure.material.law = \"granite\": is none of \"almansi-hooke\", \"saint-venant-kirchhoff\", \"neo-hookean\", \"mooney-rivlin\", \"yeoh\", \"ogden\"; take one of them"),
    ("\"saint-venant-kirchhoff\"",
     "\"neo_hookian\"",
     "line 28: structure.material.law = \"neo_hookian\": is none of \"almansi-hooke\", \"saint-venant-kirchhoff\", \"neo-hookean\", \"mooney-rivlin\", \"yeoh\", \"ogden\"; did you mean \"neo-hookean\"?"),
    ("[[probe]]",
     "[coupling]\nsub_steps = \"some\"\n[[probe]]",
     "line 50: coupling.sub_steps = \"some\": must be a whole number or \"stable\"; its meaning: sub-steps of the structure in a window, or `\"stable\"`: as many as its stability asks, which is found anew as it is strained"),
    ("[[probe]]",
     "[coupling]\nsub_steps = true\n[[probe]]",
     "line 50: coupling.sub_steps = true: is true or false, but must be a whole number or \"stable\"; its meaning: sub-steps of the structure in a window, or `\"stable\"`: as many as its stability asks, which is found anew as it is strained"),
    // Numbers.
    ("density = 1000.0",
     "density = -5",
     "line 10: fluid.density = -5: must be over 0; its meaning: density (kg/m³)"),
    ("density = 1000.0",
     "density = inf",
     "line 10: fluid.density = inf: must be finite; its meaning: density (kg/m³)"),
    ("[[probe]]",
     "[coupling]\nrelaxation = 1.5\n[[probe]]",
     "line 50: coupling.relaxation = 1.5: must be over 0 and at most 1; its meaning: relaxation, over 0 and at most 1: of the load, 1 with the mean velocity and 0.5 with that at the end if left out; of an implicit scheme's first iterations, 0.1"),
    ("[[probe]]",
     "[coupling]\nsub_steps = 0\n[[probe]]",
     "line 50: coupling.sub_steps = 0: must be at least 1; its meaning: number of sub-steps in a window"),
    ("poisson_ratio = 0.3",
     "poisson_ratio = 0.5",
     "line 30: structure.material.poisson_ratio = 0.5: must be over -1 and under 0.5; take 0.3 for metals, 0.4 to 0.49 for rubber"),
    ("poisson_ratio = 0.3",
     "poisson_ratio = 0.5\nassumption = \"plane-stress\"",
     "line 30: structure.material.poisson_ratio = 0.5: must be over -1 and under 0.5; take 0.3 for metals, 0.4 to 0.49 for rubber"),
    ("poisson_ratio = 0.3",
     "poisson_ratio = 0.3\nassumption = \"three-dimensional\"",
     "line 31: structure.material.assumption = \"three-dimensional\": does not fit two dimensions; take \"plane-strain\" or \"plane-stress\""),
    ("poisson_ratio = 0.3",
     "poisson_ratio = 0.3\nconstants = [1e6]",
     "line 31: structure.material.constants = [1000000.0]: belongs to another law; mooney-rivlin takes C10 and C01, yeoh C10, C20 and C30, ogden up to three, in Pa"),
    ("law = \"saint-venant-kirchhoff\"",
     "law = \"yeoh\"",
     "line 27: structure.material.constants: has no constants; mooney-rivlin takes C10 and C01, yeoh C10, C20 and C30, ogden up to three, in Pa"),
    ("law = \"saint-venant-kirchhoff\"\nyoungs_modulus = 1e6",
     "law = \"ogden\"\nconstants = [1e6, 2e5]\nexponents = [2]",
     "line 30: structure.material.exponents = [2]: has 1 numbers for 2 terms; ogden takes one for each of the constants, the other laws none"),
    ("law = \"saint-venant-kirchhoff\"",
     "law = \"mooney-rivlin\"\nconstants = [1e6, 2e5]",
     "line 30: structure.material.youngs_modulus = 1000000.0: is not that of the constants, 6.240000e6 Pa; leave it out"),
    // Sizes, counted before anything is made.
    ("output_interval = 0.01",
     "output_interval = 1e-9",
     "line 5: case.output_interval = 1e-9: asks for 1.0e8 outputs in 0.1 s; take an interval for at most 1e6"),
    ("[[probe]]",
     "[coupling]\nmax_window = 1e-300\n[[probe]]",
     "line 50: coupling.max_window = 1e-300: asks for 1.0e299 windows in 0.1 s; take a size for at most 1e11, or leave it out"),
    ("[[probe]]",
     "[coupling]\ndeadline = 1e300\n[[probe]]",
     "line 50: coupling.deadline = 1e300: must be at most 1e30 in size; its meaning: longest wait for an answer of a participant (s)"),
    ("[[probe]]",
     "[coupling]\ndeadline = 1e20\n[[probe]]",
     "line 50: coupling.deadline = 1e20: must be over 0 and at most 1000000; its meaning: longest wait for an answer of a participant (s)"),
    ("[0.0, -9.81]",
     "[0.0, -1e300]",
     "line 6: case.gravity.1 = -1e300: must be at most 1e30 in size; its meaning: acceleration of gravity on fluid and structure (m/s²); none if left out"),
    ("1e-6\n",
     "1e-6\nnumerics = { smoothing_ratio = 1e-3 }\n",
     "line 12: fluid.numerics.smoothing_ratio = 0.001: must be 0.5 to 3; take 1.2 to 1.5"),
    ("[structure.material]",
     "[structure.numerics]\nsmoothing_ratio = 1e-9\n[structure.material]",
     "line 28: structure.numerics.smoothing_ratio = 1e-9: must be 0.5 to 3; take 1 to 1.5"),
    ("[[probe]]",
     "[[structure.clamp]]\nname = \"again\"\nbody = \"plate\"\nface = \"right\"\n[[probe]]",
     "line 52: structure.clamp.1.face = \"right\": holds the face that \"right-end\" holds; leave one of them out"),
    ("solid_side = \"right\"",
     "solid_side = \"right\"\nmotion = { direction = [1e-200, 0.0], speed = 1.0 }",
     "line 22: fluid.wall.0.motion.direction = [0.000000000000000000000000000000000000000000000000000000000...: is zero; give a vector with a direction"),
    ("solid_side = \"right\"",
     "solid_side = \"right\"\nmotion = { direction = [1.0, 0.0], table = [[0.0, 0.1], [1.0, 0.2]] }",
     "line 22: fluid.wall.0.motion: does not begin at zero, and the wall would not stand where the case puts it; let its law begin at 0, or add a ramp"),
    ("[[probe]]",
     "[coupling]\nsub_steps = 4000000000\n[[probe]]",
     "line 50: coupling.sub_steps = 4000000000: must be at most 1000000; its meaning: number of sub-steps in a window"),
    ("dimension = 2",
     "dimension = 2\nthreads = 1000000",
     "line 4: case.threads = 1000000: must be at most 4096; its meaning: threads of each solver; 0, the default, is as many as the machine has, and more than four for each of its cores are not started"),
    ("1e-6\n",
     "1e-6\nnumerics = { surface_thresholds = [1.8, 1.6] }\n",
     "line 12: fluid.numerics.surface_thresholds = [1.8, 1.6]: do not grow; write the lower threshold first"),
    ("gravity = [0.0, -9.81]\n",
     "",
     "line 8: fluid.characteristic_speed: is missing, and there is neither gravity nor a velocity at the start to take it from; add it: the greatest speed to be expected (m/s)"),
    // Geometry.
    ("[0.0, -9.81]",
     "[0.0, -9.81, 0.0]",
     "line 6: case.gravity = [0.0, -9.81, 0.0]: has 3 numbers in 2 dimensions; write 2 numbers"),
    ("low = [-0.1, -0.2], high = [1.1, 1.0]",
     "low = [-0.1, 1.0], high = [1.1, -0.2]",
     "line 12: fluid.domain: low is not below high along y: 1 and -0.2; low is the corner with the least coordinates, high that with the greatest"),
    ("high = [1.0, 0.5]",
     "high = [1.0, 0.005]",
     "line 16: fluid.region.0.box: is thinner (0.005 m) than one particle spacing (0.01 m); take a smaller particle_spacing, or a thicker box"),
    ("high = [1.0, 0.5]",
     "high = [1.0, 1.5]",
     "line 16: fluid.region.0.box: reaches out of fluid.domain; enlarge the domain, or move the region"),
    ("high = [1.0, 0.0] }\n\n[[structure.clamp]]",
     "high = [1.0, 0.1] }\n\n[[structure.clamp]]",
     "line 35: structure.body.0.box: the body \"plate\" overlaps the region \"water\"; move or shrink one of them; they may touch"),
    ("high = [1.0, 0.5]",
     "high = [1.05, 0.5]",
     "line 16: fluid.region.0.box: the region \"water\" overlaps the wall \"right\"; move or shrink one of them; they may touch"),
    ("low = [0.0, -0.05], high = [1.0, 0.0] }\n\n[[structure.clamp]]",
     "low = [0.0, -0.02], high = [1.0, 0.0] }\n\n[[structure.clamp]]",
     "line 35: structure.body.0.box: is 2 layers of particles thick, and the quadratic gradient needs 3; take a particle_spacing of at most 6.667e-3 m, or structure.numerics.gradient = \"first-order\""),
    ("face = \"right\"",
     "face = \"top\"\nrows = 3",
     "line 37: structure.clamp.0: its fixed rows lie in the region \"water\"; clamp another face, or move the region"),
    ("polyline = [[0.0, 0.8], [0.0, 0.0]]",
     "polyline = [[0.1, 0.8], [0.1, 0.0]]",
     "line 16: fluid.region.0.box: the region \"water\" is cut by the wall \"left\"; move or shrink one of them; they may touch"),
    ("solid_side = \"right\"",
     "solid_side = \"left\"",
     "line 21: fluid.wall.0.solid_side = \"left\": puts the region \"water\" into the solid; take the other side, or move what is in it"),
    // Walls, participants, coupling.
    ("[0.0, 0.8], [0.0, 0.0]",
     "[0.0, 0.8]",
     "line 20: fluid.wall.0.polyline = [[0.0, 0.8]]: has fewer than two points; write [[x, y], [x, y], ...]"),
    ("[0.0, 0.8], [0.0, 0.0]",
     "[0.0, 0.8], [0.0, 0.8], [0.0, 0.0]",
     "line 20: fluid.wall.0.polyline.1 = [0.0, 0.8]: is the point before it once more; leave it out"),
    ("solid_side = \"right\"\n",
     "",
     "line 18: fluid.wall.0.solid_side: is missing; add \"left\" or \"right\": where the solid is, walking along the polyline from its first point"),
    ("polyline = [[0.0, 0.8], [0.0, 0.0]]\nsolid_side = \"right\"\n",
     "",
     "line 18: fluid.wall.0: has no shape; add box or polyline"),
    ("name = \"right\"\n",
     "name = \"right\"\npolyline = [[1, 0], [1, 1]]\nsolid_side = \"right\"\n",
     "line 23: fluid.wall.1: has both box and polyline; make two walls of it"),
    ("name = \"right\"\n",
     "name = \"right\"\nsolid_side = \"right\"\n",
     "line 25: fluid.wall.1.solid_side = \"right\": is for polylines; leave it out: a box is solid"),
    ("[[fluid.region]]\nname = \"water\"\nbox = { low = [0.0, 0.0], high = [1.0, 0.5] }\n",
     "",
     "line 9: fluid: there is no fluid in it; add a [[fluid.region]]"),
    ("[[fluid.region]]",
     "[fluid.participant]\nstart = \"own\"\ncommand = [\"x\"]\n[[fluid.region]]",
     "line 14: fluid.participant: has start and command; leave all but one of them out"),
    ("[[fluid.region]]",
     "[fluid.participant]\ncommand = []\n[[fluid.region]]",
     "line 15: fluid.participant.command = []: names no program; write [\"program\", \"argument\", ...]"),
    ("[[probe]]",
     "[coupling]\nextrapolation = 1\n[[probe]]",
     "line 50: coupling.extrapolation = 1: an explicit scheme has no iterations; leave it out, or take coupling.scheme = \"serial-implicit\" or \"parallel-implicit\""),
    ("[[probe]]",
     "[coupling]\nscheme = \"serial-implicit\"\nconvergence = { relativ = 0.1 }\n[[probe]]",
     "line 51: coupling.convergence.relativ = 0.1: there is no such key; did you mean \"relative\"?"),
    ("[[probe]]",
     "[coupling]\nscheme = \"parallel-explicit\"\nshare_core = true\n[[probe]]",
     "line 51: coupling.share_core = true: in parallel order both participants work at once; leave it out, or take coupling.scheme = \"serial-explicit\" or \"serial-implicit\""),
    ("[[probe]]",
     "[coupling]\nmapping = {}\n[[probe]]",
     "line 50: coupling.mapping: is for a structure with points of its own, and our own solver has none; leave it out, or name another structure.participant"),
    ("[[probe]]",
     "[coupling]\nfluid_mapping = {}\n[[probe]]",
     "line 50: coupling.fluid_mapping: is for a fluid with points of its own, and our own solver has none; leave it out, or name another fluid.participant"),
    // Names.
    ("name = \"right\"\n",
     "name = \"left\"\n",
     "line 24: fluid.wall.1.name = \"left\": is the name of fluid.wall.0 too; give each its own name"),
    ("name = \"water\"",
     "name = \"salt.water\"",
     "line 15: fluid.region.0.name = \"salt.water\": is no name; take letters, digits, \"-\" and \"_\", and at least one that is no digit"),
    ("body = \"plate\"\nface = \"right\"",
     "body = \"palte\"\nface = \"right\"",
     "line 39: structure.clamp.0.body = \"palte\": is no body; did you mean \"plate\"?"),
    // Clamps and loads.
    ("face = \"right\"",
     "face = \"front\"",
     "line 40: structure.clamp.0.face = \"front\": is a face in three dimensions; take \"left\", \"right\", \"bottom\" or \"top\""),
    ("face = \"right\"\n", "", "line 37: structure.clamp.0: holds nothing; add face, box or circle"),
    ("face = \"right\"",
     "box = { low = [2, 0], high = [3, 1] }",
     "line 40: structure.clamp.0.box: holds nothing of \"plate\"; let it reach into the body"),
    ("face = \"right\"",
     "face = \"right\"\nbox = { low = [0.9, -0.05], high = [1.0, 0.0] }",
     "line 37: structure.clamp.0: has both face and box; make two clamps of it"),
    ("face = \"right\"",
     "rows = 2\nbox = { low = [0.9, -0.05], high = [1.0, 0.0] }",
     "line 40: structure.clamp.0.rows = 2: is for a clamped face; leave it out"),
    // Motions.
    ("name = \"right\"\n",
     "name = \"right\"\nmotion = \"rol\"\n",
     "line 25: fluid.wall.1.motion = \"rol\": is no motion; add a [motion.NAME] of that name"),
    ("face = \"right\"",
     "face = \"right\"\nmotion = \"tilt\"",
     "line 41: structure.clamp.0.motion = \"tilt\": is no motion; add a [motion.NAME] of that name"),
    ("face = \"right\"",
     "face = \"right\"\nwith_wall = \"rigth\"",
     "line 41: structure.clamp.0.with_wall = \"rigth\": is no wall; did you mean \"right\"?"),
    ("face = \"right\"",
     "face = \"right\"\nwith_wall = \"right\"\nmotion = { direction = [0, 1], speed = 1 }",
     "line 37: structure.clamp.0: has both motion and with_wall; leave one of them out"),
    ("face = \"right\"",
     "face = \"bottom\"\nmotion = { direction = [0, 1], table = [[0, 0.1], [1, 0]] }",
     "line 41: structure.clamp.0.motion: does not begin at zero, and would tear what is clamped; let its law begin at 0, or add a ramp"),
    ("face = \"right\"",
     "face = \"bottom\"\nmotion = { direction = [0, 1], speed = 1, amplitude = 1, period = 1 }",
     "line 41: structure.clamp.0.motion: has both a sine and a speed; leave one of them out"),
    ("face = \"right\"",
     "face = \"bottom\"\nmotion = { direction = [0, 1], speed = 1, ramp = 0 }",
     "line 41: structure.clamp.0.motion.ramp = 0: must be over 0; its meaning: how long a smooth start takes (s): over it the law (of a constant speed, the speed) is multiplied by 10 x³ − 15 x⁴ + 6 x⁵ with x from 0 to 1. None if left out"),
    ("face = \"right\"",
     "face = \"right\"\nmotion = { direction = [0, 1], speed = 1 }",
     "line 37: structure.clamp.0: it holds in the wall \"right\", which stays, and the clamp moves; leave its motion out, or let the wall move too"),
    ("at = [0.5, 0.0]",
     "at = [0.5, 0.0]\nrelative_to = \"rihgt\"",
     "line 54: probe.0.relative_to = \"rihgt\": is no wall, clamp or motion; did you mean \"right\"?"),
    ("face = \"right\"",
     "face = \"right\"\ncircle = { centre = [1.0, 0.0], radius = 0.1 }",
     "line 37: structure.clamp.0: has both face and circle; make two clamps of it"),
    ("face = \"right\"",
     "circle = { centre = [1.0], radius = 0.1 }",
     "line 40: structure.clamp.0.circle.centre = [1.0]: has 1 numbers in 2 dimensions; write 2 numbers"),
    ("high = [1.0, 0.0] }\n\n[[structure.clamp]]",
     "high = [1.0, 0.0] }\njitter = 0.1\n\n[structure.numerics]\ngradient = \"first-order\"\n\n[[structure.clamp]]",
     "line 41: structure.clamp.0: its fixed rows would go on with a lattice that the body has not; take the quadratic gradient and rows = 0, or a box"),
    ("face = \"bottom\"",
     "face = \"bottom\"\nat = [0.5, 0.0]",
     "line 42: structure.load.0: has both face and at; make two loads of it"),
    ("face = \"bottom\"",
     "at = [0.5, 0.3]",
     "line 45: structure.load.0.at = [0.5, 0.3]: is outside of \"plate\"; take a point of the body"),
    ("[[0.0, 0.0], [0.01, 1.0]]",
     "[[0.0, 0.0], [0.0, 1.0]]",
     "line 47: structure.load.0.ramp.1 = [0.0, 1.0]: is not later than the pair before; let times grow"),
    ("[[0.0, 0.0], [0.01, 1.0]]",
     "[]",
     "line 47: structure.load.0.ramp = []: is empty; write [[time, factor], ...], or leave it out"),
    // Probes and references.
    ("\"displacement\"\nat = [0.5, 0.0]",
     "\"displacement\"",
     "line 49: probe.0.at: is missing; add the point (m)"),
    ("at = [0.5, 0.0]",
     "at = [0.5, 0.5]",
     "line 53: probe.0.at = [0.5, 0.5]: is farther than one particle spacing from the body \"plate\"; take a point of its reference configuration"),
    ("at = [0.5, 0.0]",
     "at = [0.5, 0.0]\nwall = \"left\"",
     "line 54: probe.0.wall = \"left\": does not go with a probe on the structure; leave it out"),
    ("at = [0.5, 0.0]",
     "at = [0.5, 0.0]\nbody = \"beam\"",
     "line 54: probe.0.body = \"beam\": is no body; there is \"plate\""),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"structure\"\nquantity = \"pressure\"\nat = [0, 0]\n[[reference]]",
     "line 58: probe.1.quantity = \"pressure\": is not recorded on the structure; there is \"displacement\", \"position\", \"velocity\", \"stress\", \"strain\", \"von-mises-stress\", \"force\", \"moment\""),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"pressure\"\nat = [5, 0]\n[[reference]]",
     "line 59: probe.1.at = [5, 0]: is outside of fluid.domain; take a point inside"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"wall\"\nquantity = \"pressure\"\nat = [0, 0]\n[[reference]]",
     "line 55: probe.1.wall: is missing, and there is more than one wall; add one of \"left\", \"right\""),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"wall\"\nwall = \"left\"\nquantity = \"pressure\"\nat = [0.5, 0.5]\n[[reference]]",
     "line 60: probe.1.at = [0.5, 0.5]: is farther than one particle spacing from the wall \"left\"; take a point of its surface"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"structure\"\nquantity = \"force\"\nat = [0, 0]\n[[reference]]",
     "line 59: probe.1.at = [0, 0]: is not for a force, which is the sum over the whole; leave it out"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"pressure\"\nat = [0.5, 0.1]\ninterval = 0\n[[reference]]",
     "line 60: probe.1.interval = 0: must be over 0; its meaning: length (s) of the intervals over which means and extremes are taken, in `probes_intervals.csv`; none if left out"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"pressure\"\nat = [0.5, 0.1]\ninterval = 0.2\n[[reference]]",
     "line 60: probe.1.interval = 0.2: is longer than the run, in which no interval would end; take at most 0.1 s"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"pressure\"\nat = [0.5, 0.1]\ninterval = 1e-9\n[[reference]]",
     "line 60: probe.1.interval = 1e-9: asks for 1.0e8 intervals in 0.1 s; take an interval for at most 1e6"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"velocity\"\nat = [0.5, 0.1]\nspan = [[0.1, 0.0]]\n[[reference]]",
     "line 60: probe.1.span = [[0.1, 0.0]]: does not go with the quantity; leave it out; there are areas for \"flux\" and \"pressure\""),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"pressure\"\nat = [0.5, 0.1]\ndirection = [1, 0]\n[[reference]]",
     "line 60: probe.1.direction = [1, 0]: does not go with the quantity; leave it out; there are directions for \"surface-height\", \"flux\" and discs"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"flux\"\nat = [0.5, 0.1]\ndirection = [1, 0]\n[[reference]]",
     "line 55: probe.1.span: is missing; add the edge of the segment (m)"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"flux\"\nat = [0.5, 0.1]\nspan = [[0.0, 0.2]]\n[[reference]]",
     "line 55: probe.1.direction: is missing; add the side to which what crosses counts as positive"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"flux\"\nat = [0.5, 0.1]\nspan = [[0.0, 0.2]]\ndirection = [0, 2]\n[[reference]]",
     "line 61: probe.1.direction = [0, 2]: lies in the area; let it point to one of the area's two sides"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"flux\"\nat = [0.5, 0.1]\nspan = [[0.0, 0.2]]\ndirection = [0, 0]\n[[reference]]",
     "line 61: probe.1.direction = [0, 0]: is zero; give a vector with a direction"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"flux\"\nat = [0.5, 0.1]\nspan = [[0.0, 0.2], [0.1, 0.0]]\ndirection = [1, 0]\n[[reference]]",
     "line 60: probe.1.span = [[0.0, 0.2], [0.1, 0.0]]: has 2 edges in 2 dimensions; write one edge"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"flux\"\nat = [0.5, 0.1]\nspan = [[0.0, 0.0]]\ndirection = [1, 0]\n[[reference]]",
     "line 60: probe.1.span = [[0.0, 0.0]]: has no area; give edges that are long and not parallel"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"flux\"\nat = [0.5, 0.1]\nspan = [[0.0, 3.0]]\ndirection = [1, 0]\n[[reference]]",
     "line 60: probe.1.span = [[0.0, 3.0]]: goes outside of fluid.domain; take an area inside"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"fluid\"\nquantity = \"flux\"\nat = [0.5, 0.1]\nradius = 0.1\ndirection = [1, 0]\n[[reference]]",
     "line 60: probe.1.radius = 0.1: there are no discs in two dimensions; write a span"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"wall\"\nwall = \"left\"\nquantity = \"pressure\"\nat = [0.0, 0.1]\nspan = [[0.1, 0.0]]\n[[reference]]",
     "line 61: probe.1.span = [[0.1, 0.0]]: goes farther than one particle spacing from the wall \"left\"; take an area of its surface"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"structure\"\nquantity = \"moment\"\n[[reference]]",
     "line 55: probe.1.at: is missing; add the point (m)"),
    ("[[reference]]",
     "[[probe]]\nname = \"p\"\non = \"structure\"\nquantity = \"strain\"\nat = [0.5, 0.0]\nrelative_to = \"left\"\n[[reference]]",
     "line 60: probe.1.relative_to = \"left\": is not for what is the same in every frame; leave it out"),
    ("probe = \"middle.uy\"",
     "probe = \"middle.uz\"",
     "line 56: reference.0.probe = \"middle.uz\": is no column of a probe; did you mean \"middle.ux\"?"),
    ("value = [-1e-3, -1e-3]",
     "value = [-1e-3]",
     "line 60: reference.0.value = [-0.001]: has length 1, and time has 2; give one number for each time"),
    ("time = [0.05, 0.1]",
     "time = [0.05, 0.05]",
     "line 59: reference.0.time.1 = 0.05: is not later than the time before; let times grow"),
    ("value = [-1e-3, -1e-3]",
     "value = [-1e-3, -1e-3]\nlow = [-2e-3, 0.0]",
     "line 61: reference.0.low.1 = 0.0: is above its value; low is the lower border"),
];

#[test]
fn every_mistake_has_line_key_value_problem_and_remedy() {
    for (from, to, expected) in ROWS {
        assert_eq!(mistakes(parse(&changed(from, to), &[])), [*expected], "{from:?} -> {to:?}");
    }
}

#[test]
fn a_second_body_must_not_overlap_and_a_probe_must_name_one() {
    let second =
        "[[structure.body]]\nname = \"second\"\nbox = { low = [0.5, -0.1], high = [0.6, -0.04] }\n[[probe]]";
    assert_eq!(
        mistakes(parse(&changed("[[probe]]", second), &[])),
        [
            "line 51: structure.body.1.box: the body \"second\" overlaps the body \"plate\"; move or shrink one of them; they may touch",
            "line 52: probe.0.body: is missing, and there is more than one body; add one of \"plate\", \"second\"",
        ]
    );
}

#[test]
fn missing_sections_are_named() {
    let general = SOUND.split("[fluid]").next().unwrap();
    assert_eq!(
        mistakes(parse(general, &[])),
        ["the case has neither [fluid] nor [structure]; add at least one of them"]
    );
    assert_eq!(mistakes(parse("", &[])), ["case: is missing; add it; its meaning: what concerns the whole"]);
    let structure = SOUND.find("[structure.material]").unwrap();
    let probe = SOUND.find("[[probe]]").unwrap();
    let fluid_only = format!("{}[coupling]\n", &SOUND[..structure]);
    assert_eq!(
        mistakes(parse(&fluid_only, &[])),
        ["line 27: coupling: there is no [structure] to couple; add [structure], or leave [coupling] out"]
    );
    let probe_without = format!("{}{}", &SOUND[..structure], &SOUND[probe..]);
    assert_eq!(
        mistakes(parse(&probe_without, &[])),
        ["line 29: probe.0.on = \"structure\": there is no [structure]; add one, or leave the probe out"]
    );
}

#[test]
fn all_mistakes_come_at_once_in_the_order_of_lines() {
    let text = changed("density = 1000.0", "densty = -1000.0")
        .replacen("end_time = 0.1", "end_time = \"long\"", 1)
        .replacen("poisson_ratio = 0.3", "poisson_ratio = 0.7", 1)
        .replacen("[[0.0, 0.8], [0.0, 0.0]]", "[[0.0, 0.8]]", 1)
        .replacen("face = \"right\"", "face = \"top\"\nrows = 3", 1);
    let found = mistakes(parse(&text, &["coupling.relaxation=0"]));
    let keys: Vec<_> = found.iter().map(|message| message.split([' ', ':']).nth(2).unwrap_or("")).collect();
    assert_eq!(found.len(), 7, "{found:#?}");
    assert!(found[0].starts_with("line 4: case.end_time = \"long\": is a string"), "{keys:?}");
    assert!(found[1].starts_with("line 10: fluid.densty = -1000.0: there is no such key"));
    // A misspelt key is read as what it was meant to be: its value is looked at too.
    assert!(found[2].starts_with("line 10: fluid.density: must be over 0"));
    assert_eq!(found[6].split(':').next(), Some("--set"));
}

#[test]
fn text_that_is_no_toml_is_told_with_its_line() {
    let found = mistakes(parse(&changed("density = 1000.0", "density 1000.0"), &[]));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with("line 10: is not TOML: "), "{found:?}");
    let twice = mistakes(parse(&changed("density = 1000.0", "density = 1000.0\ndensity = 2"), &[]));
    assert!(twice[0].starts_with("line 11: is not TOML: duplicate key"), "{twice:?}");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let errors = Case::load(Path::new("no/such/case.toml"), &[], &[]).unwrap_err();
    let message = errors.to_string();
    assert!(message.starts_with("no/such/case.toml: 1 mistake:\n  cannot be read: "), "{message}");
}

/// A record of a shaken table has some ten thousand rows: as many lines, or one.
#[test]
fn a_long_table_is_read_in_no_time() {
    for end in ["\n", ""] {
        let rows: Vec<String> =
            (0..50_000).map(|i| format!("[{i}e-4, {}e-6],{end}", i % 7 * i.min(1))).collect();
        let motion = format!("motion = {{ direction = [1.0, 0.0], table = [{}] }}", rows.concat());
        let text = changed("solid_side = \"right\"", &format!("solid_side = \"right\"\n{motion}"));
        let started = std::time::Instant::now();
        assert_eq!(mistakes(parse(&text, &[])), [""; 0]);
        // Seconds, where it was minutes.
        assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
    }
}

/// Of what would take more than this machine has, the largest part is named, with particles and memory.
#[test]
fn what_would_not_fit_into_memory_is_refused_before_it_is_made() {
    for (from, to, key) in [
        ("particle_spacing = 0.01", "particle_spacing = 1e-9", "fluid.region.0.box"),
        ("low = [-0.1, -0.2], high = [1.1, 1.0]", "low = [-1e9, -0.2], high = [1e9, 1e9]", "fluid.domain"),
    ] {
        let started = std::time::Instant::now();
        let found = mistakes(Case::parse(&changed(from, to), Path::new("case.toml"), &[], &SECTIONS));
        let named =
            |line: &&String| line.contains(key) && line.contains("GB of memory, and this machine has");
        assert!(found.iter().any(|line| named(&line)), "{key}: {found:#?}");
        assert!(started.elapsed().as_secs() < 5);
    }
    let wall = "[[fluid.wall]]\nname = \"long\"\nbox = { low = [0.0, -0.2], high = [1e12, -0.1] }\n[[structure.body]]";
    let found =
        mistakes(Case::parse(&changed("[[structure.body]]", wall), Path::new("case.toml"), &[], &SECTIONS));
    assert!(found.iter().any(|line| line.contains("\"long\"") || line.contains("fluid.wall.")), "{found:#?}");
    // Bodies are filled for a structure of another make, too, which is mapped to what fills them.
    let mapped =
        ["structure.participant.command=[\"sh\"]", "coupling.mapping.spacing=1e-7"].map(str::to_owned);
    let found = mistakes(Case::parse(SOUND, Path::new("case.toml"), &mapped, &SECTIONS));
    assert!(found.iter().any(|line| line.contains("coupling.mapping.spacing = 1e-7: ")), "{found:#?}");
}

/// Overlaps that a run would not survive, and those that are meant.
#[test]
fn what_moves_overlaps_nothing_and_bodies_stay_out_of_solids() {
    let wall = |name: &str, low: &str, high: &str, more: &str| {
        format!("[[fluid.wall]]\nname = \"{name}\"\nbox = {{ low = {low}, high = {high} }}\n{more}\n")
    };
    let lifts = "motion = { direction = [0.0, 1.0], table = [[0.0, 0.0], [1.0, 1.0]] }";
    let bed = wall("bed2", "[0.0, -0.19]", "[1.0, -0.1]", "");
    let found = |more: String| {
        let text = changed("[[structure.body]]", &format!("{more}[[structure.body]]"));
        mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS))
    };
    let fixed = found(bed.clone() + &wall("post", "[0.2, -0.15]", "[0.25, -0.05]", ""));
    assert!(!fixed.iter().any(|line| line.contains("overlaps the wall")), "{fixed:#?}");
    let gate = found(bed.clone() + &wall("gate2", "[0.2, -0.15]", "[0.25, -0.05]", lifts));
    assert!(
        gate.iter()
            .any(|line| line.contains("\"gate2\" overlaps the wall \"bed2\", and the wall \"gate2\" moves")),
        "{gate:#?}"
    );
    let held = |motion: &str| {
        let text = changed("face = \"right\"", "face = \"right\"\nrows = 3");
        let text = text.replacen("name = \"right\"\n", &format!("name = \"right\"\n{motion}\n"), 1);
        mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS))
    };
    assert_eq!(held(""), [""; 0], "rows may lie in a wall that stays");
    let gone = held(lifts);
    let named = "structure.clamp.0: it holds in the wall \"right\", which moves, and the clamp stays; let it move with the wall: with_wall = \"right\"";
    assert!(gone.iter().any(|line| line.contains(named)), "{gone:#?}");
    let thin = found(wall("foil", "[0.2, -0.15]", "[0.201, -0.05]", ""));
    assert!(
        thin.iter().any(|line| line.contains("is thinner (0.001 m) than one particle spacing")),
        "{thin:#?}"
    );
}

/// A clamp in a wall, along its surface or behind it goes with the wall; one that only touches its edge, or
/// along which it slides, may stay.
#[test]
fn a_clamp_goes_with_the_wall_that_it_holds_in() {
    let lifts = "motion = { direction = [0.0, 1.0], table = [[0.0, 0.0], [1.0, 1.0]] }";
    let rolls = "motion = { pivot = [0.5, 0.0], amplitude = 0.07, period = 1.2, ramp = 0.1 }";
    let text = |wall: &str, of_wall: &str, post: &str, clamp: &str| {
        format!(
            "[case]\ntitle = \"Post\"\ndimension = 2\nend_time = 1\noutput_interval = 1\ngravity = [0, -9.81]\nparticle_spacing = 0.01\n\
             [fluid]\ndensity = 1000\nkinematic_viscosity = 0\ndomain = {{ low = [-1, -1], high = [2, 2] }}\n\
             [[fluid.region]]\nname = \"water\"\nbox = {{ low = [0.6, 0], high = [1, 0.2] }}\n\
             [[fluid.wall]]\nname = \"tank\"\n{wall}\n{of_wall}\n\
             [structure.material]\nlaw = \"neo-hookean\"\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\ndensity = 1000\n\
             [[structure.body]]\nname = \"post\"\nbox = {post}\n[[structure.clamp]]\nname = \"foot\"\nbody = \"post\"\n{clamp}\n"
        )
    };
    let polyline = "polyline = [[0, 0.5], [0, 0], [1, 0], [1, 0.5]]\nsolid_side = \"right\"";
    let bed = "box = { low = [0.0, -0.1], high = [1.0, 0.0] }";
    let gate = "box = { low = [0.4, 0.0], high = [0.5, 1.0] }";
    let (post, beside) =
        ("{ low = [0.5, 0.0], high = [0.54, 0.2] }", "{ low = [0.5, -0.1], high = [0.54, 0.2] }");
    let (face, rows) = ("face = \"bottom\"", "face = \"bottom\"\nrows = 3");
    let held = "box = { low = [0.4, -0.1], high = [0.6, 0.05] }";
    let with = |clamp: &str| format!("{clamp}\nwith_wall = \"tank\"");
    for (wall, of_wall, body, clamp, refused) in [
        (polyline, rolls, post, face.to_owned(), true),
        (polyline, rolls, post, rows.to_owned(), true),
        (polyline, rolls, post, held.to_owned(), true),
        (polyline, rolls, post, with(face), false),
        (polyline, rolls, post, format!("{face}\n{rolls}"), false),
        (polyline, rolls, post, format!("{face}\n{lifts}"), true),
        (polyline, "", post, face.to_owned(), false),
        (bed, lifts, post, face.to_owned(), true),
        (bed, lifts, post, rows.to_owned(), true),
        (bed, lifts, post, with(rows), false),
        // Beside a gate that lifts: its edge is touched, or it slides along.
        (gate, lifts, post, face.to_owned(), false),
        (gate, lifts, beside, held.to_owned(), false),
        (gate, rolls, beside, held.to_owned(), true),
    ] {
        let text = text(wall, of_wall, body, &clamp);
        let found = mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS));
        let told = found.iter().any(|line| line.contains("it holds in the wall \"tank\""));
        assert_eq!(told, refused, "{wall} {of_wall} {body} {clamp}: {found:#?}");
        assert!(refused || found.is_empty(), "{wall} {of_wall} {body} {clamp}: {found:#?}");
    }
}

/// What is behind a polyline is in its solid, behind its corners too; beyond its ends it has none. A wall
/// that moves stays out of it.
#[test]
fn nothing_stands_in_the_solid_behind_a_polyline() {
    let found = |line: &str, more: &str| {
        let text = changed("polyline = [[0.0, 0.8], [0.0, 0.0]]", &format!("polyline = {line}"));
        let text = text.replacen("[structure.material]", &format!("{more}[structure.material]"), 1);
        mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS))
    };
    let hook = "[[0.0, 0.8], [0.0, -0.05], [1.0, -0.05]]";
    assert_eq!(found(hook, ""), [""; 0]);
    let region = |low: &str, high: &str| {
        format!("[[fluid.region]]\nname = \"more\"\nbox = {{ low = {low}, high = {high} }}\n")
    };
    // Left of the corner and under it: no piece has it before it.
    let behind = found(hook, &region("[-0.08, -0.15]", "[-0.02, -0.1]"));
    let named = "line 21: fluid.wall.0.solid_side = \"right\": puts the region \"more\" into the solid; take the other side, or move what is in it";
    assert_eq!(behind, [named]);
    // Beyond the end of the wall on the left, which stands on nothing there.
    assert_eq!(found("[[0.0, 0.8], [0.0, 0.0]]", &region("[-0.08, -0.15]", "[-0.02, -0.1]")), [""; 0]);
    let body = "[[structure.body]]\nname = \"post\"\nbox = { low = [-0.06, -0.11], high = [-0.01, -0.06] }\n";
    let body = found(hook, body);
    assert!(body.iter().any(|line| line.contains("puts the body \"post\" into the solid")), "{body:#?}");
    // In the open, far behind the wall's particles.
    let far = "[[structure.body]]\nname = \"post\"\nbox = { low = [-2.08, 0.15], high = [-2.02, 0.2] }\n";
    let far = found(hook, far);
    assert!(!far.iter().any(|line| line.contains("into the solid")), "{far:#?}");

    let gate = |low: &str, moves: bool| {
        let motion = "motion = { direction = [0.0, 1.0], table = [[0.0, 0.0], [1.0, 1.0]] }\n";
        let motion = if moves { motion } else { "" };
        let gate = format!("box = {{ low = {low}, high = [1.05, 0.9] }}");
        format!("[[fluid.wall]]\nname = \"gate\"\n{gate}\n{motion}")
    };
    let line = "[[0.0, 0.8], [0.0, -0.05], [1.1, -0.05]]";
    let overlap = |line: &&String| {
        line.contains(
            "the wall \"gate\" overlaps the solid of the wall \"left\", and the wall \"gate\" moves",
        )
    };
    for (low, moves, refused) in
        [("[1.0, -0.1]", true, true), ("[1.0, -0.1]", false, false), ("[1.0, -0.05]", true, false)]
    {
        let found = found(line, &gate(low, moves));
        assert_eq!(found.iter().filter(overlap).count(), usize::from(refused), "{low} {moves}: {found:#?}");
    }
}

/// Where two boxes touch at a corner alone and there is water on one side of it, the other side must hold
/// something.
#[test]
fn walls_that_touch_at_a_corner_alone_are_told() {
    let found = |bed: &str, more: &str| {
        let text = changed("low = [1.0, -0.1], high = [1.1, 0.8]", "low = [1.0, 0.0], high = [1.1, 0.8]");
        let text = text.replacen(
            "[structure.material]",
            &format!("[[fluid.wall]]\nname = \"bed\"\nbox = {bed}\n{more}[structure.material]"),
            1,
        );
        let text =
            text.replacen("low = [0.0, -0.05], high = [1.0, 0.0]", "low = [0.4, 0.5], high = [0.6, 0.6]", 1);
        let text = text.replacen("face = \"right\"", "box = { low = [0.4, 0.5], high = [0.5, 0.6] }", 1);
        let found = mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS));
        found.into_iter().filter(|line| line.contains("at an edge alone")).collect::<Vec<_>>()
    };
    let bed = "{ low = [0.0, -0.1], high = [1.0, 0.0] }";
    let [told] = &found(bed, "")[..] else { panic!("one corner is open") };
    let wanted = "fluid.wall.2.box: the wall \"bed\" touches the wall \"right\" at an edge alone, and what is behind it is open; let one of them reach behind the other";
    assert!(told.contains(wanted), "{told}");
    assert_eq!(found("{ low = [0.0, -0.1], high = [1.1, 0.0] }", ""), [""; 0]);
    let third = "[[fluid.wall]]\nname = \"foot\"\nbox = { low = [1.0, -0.1], high = [1.1, 0.0] }\n";
    assert_eq!(found(bed, third), [""; 0]);
}
