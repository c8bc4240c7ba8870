//! What moves: fields at the last completed step, and the ones that the next step is made in.

use crate::error::Result;
use crate::memory;

const PURPOSE: &str = "fields";

/// Fields at one time, in the inner order, `dimension` numbers a point.
#[derive(Debug)]
pub(crate) struct Kinematics {
    pub(crate) displacement: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) acceleration: Vec<f64>,
    /// Internal force per volume.
    pub(crate) force: Vec<f64>,
    /// Body force of the conditions; empty while there are none.
    pub(crate) load: Vec<f64>,
}

/// The state of a simulation. A step is made in `next` and becomes current as a whole, or not at all.
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) current: Kinematics,
    pub(crate) next: Kinematics,
    /// Body force that the host set itself; it adds to that of the conditions.
    pub(crate) host_load: Option<Vec<f64>>,
    pub(crate) time: f64,
    pub(crate) steps: u64,
    /// Forces have been computed at the current displacement, or it has been committed; else the last such
    /// displacement is kept in `next`.
    pub(crate) pulled: bool,
    /// The current force belongs to the current displacement and bonds.
    pub(crate) force_fresh: bool,
    /// The current load and acceleration belong to the current force, time and conditions.
    pub(crate) loads_fresh: bool,
    pub(crate) ledger: Ledger,
    /// What was borne at the last equilibrium; `None` before the first.
    pub(crate) settled: Option<Settled>,
    /// Time step of the last step made; 0 before the first.
    pub(crate) last_time_step: f64,
}

/// An equilibrium.
#[derive(Debug)]
pub(crate) struct Settled {
    /// All body forces that were borne.
    pub(crate) load: Vec<f64>,
    /// Steps of the simulation then.
    pub(crate) steps: u64,
}

/// The account of energy: what went in by work, and what the host changed by hand.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Ledger {
    /// Work of body forces and constraints since the start.
    pub(crate) work: f64,
    /// Kinetic, elastic and dissipated energy that no work accounts for: it was there at the start, or
    /// the host wrote it into the state.
    pub(crate) given: f64,
    /// Closure error at the last time the host changed the state.
    pub(crate) carried: f64,
    /// Whether `given` belongs to the state as it is.
    pub(crate) open: bool,
}

impl Kinematics {
    fn new(components: usize) -> Result<Self> {
        Ok(Self {
            displacement: memory::filled(0.0, components, PURPOSE)?,
            velocity: memory::filled(0.0, components, PURPOSE)?,
            acceleration: memory::filled(0.0, components, PURPOSE)?,
            force: memory::filled(0.0, components, PURPOSE)?,
            load: Vec::new(),
        })
    }

    fn bytes(&self) -> usize {
        [&self.displacement, &self.velocity, &self.acceleration, &self.force, &self.load]
            .into_iter()
            .map(memory::bytes)
            .sum()
    }
}

impl State {
    pub(crate) fn new(points: usize, dimension: usize) -> Result<Self> {
        let components = points * dimension;
        Ok(Self {
            current: Kinematics::new(components)?,
            next: Kinematics::new(components)?,
            host_load: None,
            time: 0.0,
            steps: 0,
            pulled: true,
            force_fresh: false,
            loads_fresh: false,
            ledger: Ledger::default(),
            settled: None,
            last_time_step: 0.0,
        })
    }

    /// The current displacement, for the host to change; the one at which bonds have last pulled is kept
    /// aside.
    pub(crate) fn displacement_mut(&mut self) -> &mut Vec<f64> {
        let Kinematics { displacement, .. } = &mut self.current;
        if std::mem::replace(&mut self.pulled, false) {
            self.next.displacement.copy_from_slice(displacement);
        }
        self.force_fresh = false;
        displacement
    }

    /// Body forces of conditions need room, which most scenes do without.
    pub(crate) fn make_room_for_loads(&mut self) -> Result<()> {
        if self.current.load.is_empty() {
            let components = self.current.displacement.len();
            let current = memory::filled(0.0, components, PURPOSE)?;
            self.next.load = memory::filled(0.0, components, PURPOSE)?;
            self.current.load = current;
        }
        Ok(())
    }

    /// Room for the host's own body force.
    pub(crate) fn host_load_mut(&mut self) -> Result<&mut Vec<f64>> {
        let values = match self.host_load.take() {
            Some(values) => values,
            None => memory::filled(0.0, self.current.displacement.len(), PURPOSE)?,
        };
        Ok(self.host_load.insert(values))
    }

    /// Body force per volume at a component: the host's and that of the conditions in `load`.
    #[inline(always)]
    pub(crate) fn body_force(host: Option<&[f64]>, load: &[f64], component: usize) -> f64 {
        let own = host.map_or(0.0, |values| values[component]);
        own + load.get(component).copied().unwrap_or(0.0)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.current.bytes()
            + self.next.bytes()
            + self.host_load.as_ref().map_or(0, memory::bytes)
            + self.settled.as_ref().map_or(0, |settled| memory::bytes(&settled.load))
    }
}
