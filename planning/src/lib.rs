//! Occupancy grids, path planners and local memorial path planning for indoor robots.
