// Chooses whose sticks count: between radio and stations, and all that reads sticks.
#pragma once

#include <array>
#include <cstdint>

#include "manual_control_ports.hpp"

namespace stator::apps::manual_control {

// Runs at a fixed period, shorter than that of either. Who flies by sticks keeps flying: one that
// falls silent is not replaced by the other, whose sticks may stand anywhere, but reads as lost. A
// station takes over by choosing a mode of sticks while it sends some; the radio takes over with a
// switch or a stick that moves. While no sticks fly, the radio counts where it is heard, and else a
// station.
class ManualControl {
  public:
    void step(ManualControlPorts& ports);

  private:
    using Sticks = std::array<float, 4>;

    static Sticks sticks_of(const ManualControlSetpoint& setpoint);
    bool radio_moves(const ManualControlPorts& ports);
    bool station_chooses(const ManualControlPorts& ports) const;
    void choose(const ManualControlPorts& ports);

    bool by_station_ = false;
    Sticks rest_{};  // of the radio, when a station took over
    std::array<uint8_t, 4> switches_{};
    ManualControlSetpoint newest_{};
};

}  // namespace stator::apps::manual_control
