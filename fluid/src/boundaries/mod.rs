//! What bounds any fluid: walls and how they move, sides through which space repeats, contact.

pub mod contact;
pub mod filling;
pub mod period;
pub mod sampling;
pub mod shapes;
pub mod ties;
pub mod wall_motion;
pub mod walls;
