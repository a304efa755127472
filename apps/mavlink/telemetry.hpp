// What the vehicle tells of itself, in MAVLink's messages and units.
#pragma once

#include <cstdint>

#include "link.hpp"
#include "mavlink_ports.hpp"
#include "stator/geodesy.hpp"

namespace stator::apps::mavlink {

enum class Told : uint8_t {
    kSent,
    kNoRoom,   // the line is full
    kNothing,  // it is not known yet
    kUnknown   // we do not send such a message
};

class Telemetry {
  public:
    // Once in each activation, before anything is told.
    void update(const MavlinkPorts& ports);
    Told tell(uint32_t id, Link& link, const MavlinkPorts& ports) const;
    // One of the modes that can be chosen, by its number from 0 on.
    static void tell_mode(unsigned number, Link& link);

    // Whether armed state, mode or what they follow from is another one than in the activation
    // before.
    bool is_status_new() const { return is_status_new_; }
    // Whether the mission, its item or its state is another one.
    bool is_mission_new() const { return is_mission_new_; }
    // Of N, as far as it is known.
    bool knows_earth() const { return knows_earth_; }
    const math::LocalFrame& frame() const { return frame_; }
    float reference_altitude() const { return reference_altitude_; }
    float home_down() const { return home_N_[2]; }

  private:
    Told tell_position(uint32_t id, Link& link, const MavlinkPorts& ports) const;
    Told tell_attitude(uint32_t id, Link& link, const MavlinkPorts& ports) const;
    Told tell_sensors(uint32_t id, Link& link, const MavlinkPorts& ports) const;
    Told tell_orbit(Link& link, const MavlinkPorts& ports) const;
    Told tell_status(uint32_t id, Link& link, const MavlinkPorts& ports) const;
    mav::Heartbeat heartbeat(const MavlinkPorts& ports) const;
    mav::SysStatus sys_status(const MavlinkPorts& ports) const;
    mav::GlobalPositionInt global_position(const VehicleLocalPosition& position,
                                           uint32_t boot_ms) const;
    mav::HomePosition home_position(uint64_t now_us) const;
    void update_mission(const MavlinkPorts& ports);
    mav::Odometry odometry(const MavlinkPorts& ports) const;

    math::LocalFrame frame_;
    float reference_altitude_ = 0.0F;
    bool knows_earth_ = false;
    // Where it was armed; before that, where it stands.
    std::array<float, 3> home_N_{};
    float home_heading_ = 0.0F;
    bool knows_home_ = false;
    uint32_t told_status_ = 0;
    bool is_status_new_ = false;
    mav::MissionCurrent mission_{};
    bool is_complete_ = false;  // the mission
    bool is_mission_new_ = false;
};

}  // namespace stator::apps::mavlink
