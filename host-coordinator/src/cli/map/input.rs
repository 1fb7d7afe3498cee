//! Reads a map of any kind that is known, and says which it was.

use std::{
    error::Error,
    fmt::Display,
    fs,
    path::{Path, PathBuf},
};

use planning::{
    clearance,
    floor_plan::{FloorPlan, Layout, Scale},
    formats::{image, lif, rmf, ros},
    frame::Frame,
};

type Failure = Box<dyn Error>;

/// Which map, and how it is read.
#[derive(clap::Args)]
pub struct Input {
    /// The map: MovingAI .map, ROS map_server YAML, Open-RMF building.yaml or nav graph, or LIF JSON
    file: PathBuf,
    /// The storey or layout, if there are several
    #[arg(long, value_name = "NAME")]
    level: Option<String>,
    /// How long a cell is, for maps that do not say it [default: 0.05; 1 for MovingAI maps]
    #[arg(long, value_name = "METRES", value_parser = length)]
    resolution: Option<f64>,
    /// Block what the middle of a round robot of this radius does not reach
    #[arg(long, value_name = "METRES", default_value_t = 0.0, value_parser = super::super::non_negative)]
    radius: f64,
    /// How thick walls are that a plan draws as lines
    #[arg(long, value_name = "METRES", default_value_t = 0.1, value_parser = super::super::non_negative)]
    wall: f64,
    /// How wide lanes are in a plan of nothing but lanes
    #[arg(long, value_name = "METRES", default_value_t = 1.0, value_parser = length)]
    lane: f64,
}

fn length(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (0.001..=1000.0).contains(number));
    number.ok_or_else(|| "expected metres, from 0.001 to 1000".into())
}

/// What a file holds.
enum Kind {
    MovingAi,
    Ros,
    Building,
    NavGraph,
    Lif,
}

/// A map as it was read.
pub struct Read {
    /// What it is called.
    pub kind: &'static str,
    pub layout: Layout,
}

impl Input {
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Reads the map.
    pub fn read(&self) -> Result<Read, Failure> {
        let bytes = fs::read(&self.file)
            .map_err(|error| format!("{} cannot be read ({error}); name a map", self.file.display()))?;
        let text = String::from_utf8(bytes).map_err(|_| {
            format!("{} is no text; name a map, or the YAML file of a picture", self.file.display())
        })?;
        let (kind, mut layout) = match self.kind(&text)? {
            Kind::MovingAi => ("MovingAI map", self.moving_ai(text)?),
            Kind::Ros => ("ROS map", self.ros(&text)?),
            Kind::Building => ("Open-RMF building", self.plan(rmf::building::read(&text))?),
            Kind::NavGraph => ("Open-RMF navigation graph", self.plan(rmf::nav_graph::read(&text))?),
            Kind::Lif => ("LIF layout", self.plan(lif::read(&text))?),
        };
        if self.radius > 0.0 {
            layout.grid = clearance::inflated(&layout.grid, self.radius / layout.frame.resolution_m);
        }
        Ok(Read { kind, layout })
    }

    fn failure(&self, error: impl Display) -> Failure {
        format!("{}: {error}", self.file.display()).into()
    }

    /// What the file is, by its name and by what is in it.
    fn kind(&self, text: &str) -> Result<Kind, Failure> {
        let text = text.trim_start_matches('\u{feff}');
        let has_key = |key: &str| {
            text.lines()
                .any(|line| line.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with(':')))
        };
        let extension = self.file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        Ok(match () {
            () if text.trim_start().starts_with("type") || extension == "map" => Kind::MovingAi,
            () if text.trim_start().starts_with('{') => Kind::Lif,
            () if has_key("image") => Kind::Ros,
            () if has_key("building_name") => Kind::NavGraph,
            () if has_key("levels") => Kind::Building,
            () => {
                return Err(self.failure(
                    "is no map that is known: expected `type octile` (MovingAI), `image:` (ROS), `levels:` \
                     (Open-RMF) or JSON (LIF)",
                ));
            }
        })
    }

    fn moving_ai(&self, text: String) -> Result<Layout, Failure> {
        self.has_one_level()?;
        let grid = super::parse(&self.file, Ok(text))?;
        let resolution_m = self.resolution.unwrap_or(1.0);
        let frame = Frame { resolution_m, origin_m: [0.0; 2], yaw_rad: 0.0, rows: grid.height() };
        Ok(Layout::of_cells(grid, frame, 0))
    }

    fn ros(&self, text: &str) -> Result<Layout, Failure> {
        self.has_one_level()?;
        if self.resolution.is_some() {
            return Err(self.failure("says its own resolution; leave `--resolution` out"));
        }
        let description = ros::Description::read(text).map_err(|error| self.failure(error))?;
        let picture = self.file.parent().unwrap_or(Path::new("")).join(&description.image);
        let bytes = fs::read(&picture).map_err(|error| {
            self.failure(format!("its image {} cannot be read ({error}): expected a file", picture.display()))
        })?;
        let image = image::read(&bytes).map_err(|error| format!("{}: {error}", picture.display()))?;
        let ros::RosMap { grid, frame, unknown } =
            description.map(&image).map_err(|error| self.failure(error))?;
        Ok(Layout::of_cells(grid, frame, unknown))
    }

    fn has_one_level(&self) -> Result<(), Failure> {
        match &self.level {
            Some(level) => Err(self.failure(format!("has no level `{level}`; leave `--level` out"))),
            None => Ok(()),
        }
    }

    /// The plan that was asked for, drawn.
    fn plan(&self, plans: Result<Vec<FloorPlan>, impl Display>) -> Result<Layout, Failure> {
        let plans = plans.map_err(|error| self.failure(error))?;
        let names = || plans.iter().map(|plan| format!("`{}`", plan.name)).collect::<Vec<_>>().join(", ");
        let plan = match (&self.level, plans.as_slice()) {
            (None, [only]) => only,
            (None, _) => {
                return Err(self.failure(format!("has several levels; choose `--level` of {}", names())));
            }
            (Some(level), _) => plans.iter().find(|plan| plan.name == *level).ok_or_else(|| {
                self.failure(format!("has no level `{level}`; choose `--level` of {}", names()))
            })?,
        };
        let resolution_m = self.resolution.unwrap_or(0.05);
        let scale = Scale { resolution_m, wall_m: self.wall, lane_m: self.lane };
        plan.draw(scale).map_err(|error| self.failure(error))
    }
}
