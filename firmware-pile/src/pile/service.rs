//! What a person's tool at a desk asks, and what it is answered. It may ask everything and clear
//! faults, and make a board a pile; it may not grant or revoke.

use heapless::Vec;
use protocol::{
    CurrentA, DeviceId, Message, PendingPass, PendingPasses, PileId, PileParameters, PileReadings, PileRow,
    PowerW, TemperatureC, Topic, VoltageV, limits,
};

use super::{ChargingPile, say};
use crate::{
    io::{Messages, To},
    parameters::Parameters,
};

/// Up to where the table was told to who asked for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Telling {
    /// Nobody has asked, or all of it was told.
    #[default]
    Nothing,
    /// From its first row on: the pile's own.
    All,
    /// What comes after the row of this pile.
    After(PileId),
}

impl ChargingPile {
    pub(super) fn hear_service(&mut self, message: &Message, messages: &mut Messages) {
        match message {
            Message::Hello(_) => self.answer_tool(messages),
            Message::Query(query) => self.answer(query.topic, messages),
            Message::ClearFault(command) => self.clear_fault(DeviceId::Service, *command, messages),
            Message::Provision(provision) => self.provision(provision, messages),
            _ => {}
        }
    }

    fn answer(&mut self, topic: Topic, messages: &mut Messages) {
        let answer = match topic {
            Topic::State => {
                say(messages, To::Service, Message::PileState(self.state()));
                Message::PileReadings(self.readings())
            }
            Topic::Faults => Message::PileFaults(self.faults.told()),
            Topic::Passes => Message::PendingPasses(self.pending_passes()),
            Topic::Parameters => Message::PileParameters(self.parameters.told()),
            Topic::Table => {
                self.telling = Telling::All;
                return;
            }
        };
        say(messages, To::Service, answer);
    }

    /// The next part of the table, if somebody has asked for it: one a step, the last one not full.
    /// The own row comes first, which gossip ends with.
    pub(super) fn tell_table(&mut self, messages: &mut Messages) {
        let (own, after) = match self.telling {
            Telling::Nothing => return,
            Telling::All => (Some(self.row()), None),
            Telling::After(pile) => (None, Some(pile)),
        };
        let others = self.table.rows().iter().filter(|row| Some(row.pile) > after);
        let rows: Vec<PileRow, { limits::ROWS_PER_TABLE }> =
            own.into_iter().chain(others.copied()).take(limits::ROWS_PER_TABLE).collect();
        self.telling = match rows.last() {
            Some(last) if rows.is_full() => Telling::After(last.pile),
            _ => Telling::Nothing,
        };
        say(messages, To::Service, Message::PileTable(protocol::PileTable { rows }));
    }

    fn readings(&self) -> PileReadings {
        let sample = self.safety.sample(self.now);
        let sensed = sample.map(|sample| sample.sensors);
        let readings = sample.map(|sample| sample.readings);
        let is = |flag: Option<bool>| flag.unwrap_or(false);
        PileReadings {
            voltage: readings.and_then(|readings| readings.voltage_v).map(VoltageV::clamped),
            current: readings.and_then(|readings| readings.current_a).map(CurrentA::clamped),
            temperature: readings.and_then(|readings| readings.contact_c).map(TemperatureC::clamped),
            current_limit: CurrentA::clamped(self.power().current_limit_a),
            contactor_closed: is(sensed.map(|sensors| sensors.contactor_closed)),
            mated: is(sensed.map(|sensors| sensors.mated)),
            emergency_stop: is(sensed.map(|sensors| sensors.emergency_stop)),
            mains: is(sensed.map(|sensors| sensors.mains)),
        }
    }

    /// What waits for its acknowledgement, then what was counted since.
    fn pending_passes(&self) -> PendingPasses {
        let reported = self.reports.pending().map(|count| PendingPass {
            tag: count.tag,
            period: Some(count.period),
            passes: count.passes,
        });
        PendingPasses {
            passes: reported.chain(self.passes.pending()).take(limits::PASSES_PER_REPORT).collect(),
        }
    }
}

impl Parameters {
    fn told(&self) -> PileParameters {
        PileParameters {
            power: PowerW::clamped(self.power_w),
            eta: self.eta,
            voltage_max: VoltageV::clamped(self.limits.voltage_max_v),
            current_max: CurrentA::clamped(self.limits.current_max_a),
            derate_from: TemperatureC::clamped(self.limits.derate_from_c),
            stop_at: TemperatureC::clamped(self.limits.stop_at_c),
            dock_enter_dbm: self.docked.enter_dbm,
            dock_leave_dbm: self.docked.leave_dbm,
        }
    }
}
