// Chooses whose sticks count.
#include "manual_control.hpp"

#include "stator/scalar.hpp"

namespace stator::apps::manual_control {

namespace {

using Nav = VehicleStatus::NavState;

constexpr int32_t kRadioOnly = 0;
constexpr int32_t kStationOnly = 1;

bool is_by_sticks(Nav mode) {
    return mode == Nav::kManual || mode == Nav::kStabilized || mode == Nav::kAltitude ||
           mode == Nav::kPosition;
}

bool sticks_fly(const ManualControlPorts& ports) {
    return ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed &&
           is_by_sticks(ports.status->nav_state);
}

bool hears_radio(const ManualControlPorts& ports) {
    return ports.radio && ports.radio->valid;
}

}  // namespace

ManualControl::Sticks ManualControl::sticks_of(const ManualControlSetpoint& setpoint) {
    return {setpoint.roll, setpoint.pitch, setpoint.yaw, setpoint.throttle};
}

// A stick that is further from where it rested, or any switch.
bool ManualControl::radio_moves(const ManualControlPorts& ports) {
    bool moves = false;
    if (ports.switches) {
        const ManualControlSwitches& s = *ports.switches;
        const std::array<uint8_t, 4> now{s.mode_slot, static_cast<uint8_t>(s.arm_switch),
                                         static_cast<uint8_t>(s.return_switch),
                                         static_cast<uint8_t>(s.kill_switch)};
        moves = now != switches_;
        switches_ = now;
    }
    if (!hears_radio(ports)) return false;
    const Sticks sticks = sticks_of(*ports.radio);
    for (unsigned i = 0; i < sticks.size(); ++i) {
        moves = moves || math::abs(sticks[i] - rest_[i]) > ports.params->takeover;
    }
    return moves;
}

bool ManualControl::station_chooses(const ManualControlPorts& ports) const {
    return ports.station && ports.command && ports.command.is_new() &&
           ports.command->action == VehicleCommand::Action::kSetMode &&
           is_by_sticks(static_cast<Nav>(ports.command->nav_state));
}

void ManualControl::choose(const ManualControlPorts& ports) {
    const bool moves = radio_moves(ports);
    if (ports.params->source == kRadioOnly || ports.params->source == kStationOnly) {
        by_station_ = ports.params->source == kStationOnly;
        return;
    }
    if (station_chooses(ports)) {
        by_station_ = true;
        if (ports.radio) rest_ = sticks_of(*ports.radio);
        return;
    }
    if (by_station_ && moves) by_station_ = false;
    if (!sticks_fly(ports)) by_station_ = !hears_radio(ports) && ports.station;
    if (!by_station_ && ports.radio) rest_ = sticks_of(*ports.radio);
}

void ManualControl::step(ManualControlPorts& ports) {
    choose(ports);
    const auto& source = by_station_ ? ports.station : ports.radio;
    const bool was_valid = newest_.valid;
    if (source) newest_ = *source;
    newest_.valid = source && source->valid;
    // Neither more often than it comes, nor as new what is old.
    if (source.is_new() || newest_.valid != was_valid)
        ports.sticks.publish([&] { return newest_; });
}

}  // namespace stator::apps::manual_control
