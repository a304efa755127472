// Decides what the vehicle does: arms, disarms, and chooses the flight mode.
#pragma once

#include <cstdint>

#include "commander_ports.hpp"
#include "failsafe.hpp"
#include "hysteresis.hpp"

namespace stator::apps::commander {

// Runs at a fixed period. An input that is absent counts against arming, and in flight as lost. A
// mode switch counts when it moves, and only if the failsafe table lets that mode go on. After a
// failsafe nothing returns by itself to the mode before. On the ground a failsafe only disarms, and
// a return is refused: nothing but the pilot's stick, a mission or a take-off leaves the ground.
// A command counts like a switch that moves; the newest of both wins. A motor turns for a test only
// while the vehicle is disarmed on the ground and a ground station is heard.
class Commander {
  public:
    void step(CommanderPorts& ports);

  private:
    using Nav = VehicleStatus::NavState;
    static constexpr float kLong_s = 1e5F;

    void take_health(const CommanderPorts& ports, float dt);
    void take_place(const CommanderPorts& ports, float dt);
    void take_events(const CommanderPorts& ports, float dt);
    void take_silence(const CommanderPorts& ports, float dt);
    bool is_uncontrolled(const CommanderPorts& ports) const;
    void take_wish(const CommanderPorts& ports, float dt);
    void take_arm_switch(const CommanderPorts& ports, float dt);
    void take_command(CommanderPorts& ports);
    bool may_test_motors(const CommanderPorts& ports) const;
    VehicleCommandAck::Result test_motor(const CommanderPorts& ports,
                                         const VehicleCommand& command);
    void run_motor_test(CommanderPorts& ports, float dt);
    VehicleCommandAck::Result obey(const CommanderPorts& ports, const VehicleCommand& command);
    VehicleCommandAck::Result arm_by_command(const CommanderPorts& ports);
    void fly(const CommanderPorts& ports, float dt);
    void arm(const CommanderPorts& ports);
    void disarm();
    void choose(const CommanderPorts& ports, Nav mode);
    void disarm_where_due(const CommanderPorts& ports, float dt);

    HealthReport health_{};
    Hysteresis estimate_holds_;
    Hysteresis is_down_;
    Hysteresis height_is_gone_;
    Hysteresis position_is_gone_;
    Hysteresis pilot_is_gone_;
    Events events_ = 0;
    float no_setpoint_s_ = kLong_s;  // for the mode offboard
    float no_station_s_ = 0.0F;
    bool has_heard_station_ = false;
    bool has_heard_motors_ = false;

    bool is_armed_ = false;
    bool has_flown_ = false;    // since it was armed last
    bool is_on_ground_ = true;  // for certain
    float height_ = 0.0F;       // above home, when it was known last
    float blind_for_s_ = 0.0F;
    float moved_s_ = 0.0F;  // since it was last seen to move up or down
    Nav mode_ = Nav::kHold;
    Nav wish_ = Nav::kHold;  // of the mode switch
    VehicleStatus::FailsafeEvent failsafe_ = VehicleStatus::FailsafeEvent::kNone;
    HomePosition home_{};

    bool arm_switch_was_on_ = true;  // one that is on from the start must go off first
    float arming_left_s_ = 0.0F;
    bool is_testing_ = false;
    float test_left_s_ = 0.0F;
    MotorTest test_{};
    uint8_t mode_slot_ = 0;
    bool return_was_on_ = false;
    Hysteresis kill_holds_;
    Hysteresis stands_;
    Hysteresis idles_;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::commander
