//! Sound cases, small ones, which are mutated.

/// Coupled, fluid alone, structure alone in three dimensions, iterated.
pub const CASES: [&str; 4] = [
    r#"
[case]
title = "Column on a plate"
dimension = 2
end_time = 0.002
output_interval = 0.001
gravity = [0.0, -9.81]
particle_spacing = 0.02
[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [-0.1, -0.2], high = [0.6, 0.6] }
numerics = { smoothing_ratio = 1.2 }
[[fluid.region]]
name = "water"
box = { low = [0.0, 0.0], high = [0.4, 0.3] }
[[fluid.wall]]
name = "left"
polyline = [[0.0, 0.5], [0.0, 0.0]]
solid_side = "right"
[[fluid.wall]]
name = "right"
box = { low = [0.4, -0.1], high = [0.5, 0.5] }
[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 2700.0
[[structure.body]]
name = "plate"
box = { low = [0.0, -0.08], high = [0.4, 0.0] }
[[structure.clamp]]
name = "right-end"
body = "plate"
face = "right"
[[structure.load]]
name = "push"
body = "plate"
face = "bottom"
force = [0.0, 10.0]
ramp = [[0.0, 0.0], [0.01, 1.0]]
[coupling]
max_window = 1e-3
sub_steps = 20
deadline = 5.0
[[probe]]
name = "middle"
on = "structure"
quantity = "displacement"
at = [0.2, 0.0]
"#,
    r#"
[case]
title = "Gate"
dimension = 2
end_time = 0.002
output_interval = 0.001
gravity = [0.0, -9.81]
threads = 1
particle_spacing = 0.02
[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [-0.2, -0.2], high = [1.0, 1.0] }
periodic = []
[motion.lift]
direction = [0.0, 1.0]
table = [[0.0, 0.0], [0.1, 0.1]]
start = 1e-4
ramp = 1e-3
[[fluid.region]]
name = "water"
box = { low = [0.0, 0.0], high = [0.2, 0.2] }
velocity = [0.1, 0.0]
jitter = 0.1
[[fluid.wall]]
name = "bed"
box = { low = [-0.1, -0.1], high = [0.9, 0.0] }
slip = "no-slip"
[[fluid.wall]]
name = "gate"
box = { low = [0.2, 0.0], high = [0.25, 0.4] }
motion = "lift"
[[probe]]
name = "force"
on = "wall"
wall = "gate"
quantity = "force"
[[probe]]
name = "front"
on = "fluid"
quantity = "extent"
relative_to = "gate"
"#,
    r#"
[case]
title = "Beam"
dimension = 3
end_time = 1e-4
output_interval = 1e-4
particle_spacing = 0.02
[structure]
numerics = { gradient = "quadratic" }
[structure.material]
law = "neo-hookean"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0
[[structure.body]]
name = "beam"
box = { low = [0.0, 0.0, 0.0], high = [0.2, 0.08, 0.08] }
velocity = [0.0, 0.1, 0.0]
[[structure.clamp]]
name = "root"
body = "beam"
face = "left"
"#,
    r#"
[case]
title = "Light block in oil"
dimension = 2
end_time = 0.002
output_interval = 0.001
gravity = [0.0, -9.81]
particle_spacing = 0.02
[fluid]
density = 900.0
kinematic_viscosity = 0.1
domain = { low = [-0.1, -0.1], high = [0.5, 0.5] }
numerics = { tearing = "at-surface", tensile_limit = 0.0, smagorinsky = 0.1, artificial_viscosity = 0.1 }
[[fluid.region]]
name = "oil"
box = { low = [0.0, 0.0], high = [0.4, 0.2] }
[[fluid.wall]]
name = "tank"
polyline = [[0.0, 0.4], [0.0, 0.0], [0.4, 0.0], [0.4, 0.4]]
solid_side = "right"
slip = "no-slip"
[structure]
particle_spacing = 0.01
numerics = { gradient = "first-order", smoothing_ratio = 1.2, hourglass = 0.05, damping = 1.0, step_fraction = 0.5 }
[structure.material]
law = "neo-hookean"
youngs_modulus = 1e5
poisson_ratio = 0.3
density = 500.0
[[structure.body]]
name = "block"
box = { low = [0.1, 0.2], high = [0.2, 0.26] }
[coupling]
scheme = "serial-implicit"
max_window = 1e-3
sub_steps = "stable"
extrapolation = 1
acceleration = { method = "iqn-ils" }
convergence = { relative = 1e-3, max_iterations = 5 }
[[probe]]
name = "block"
on = "structure"
quantity = "force"
"#,
];
