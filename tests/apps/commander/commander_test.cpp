// The commander: each arming check both ways, what the pilot may choose, each failsafe event, and
// when it disarms.
#include "commander.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <optional>

#include "stator/testing.hpp"

namespace stator::apps::commander {
namespace {

using Nav = VehicleStatus::NavState;
using Event = VehicleStatus::FailsafeEvent;
using Warning = BatteryStatus::Warning;
using Action = VehicleCommand::Action;
using Answer = VehicleCommandAck::Result;

class CommanderTest : public ::testing::Test {
  protected:
    CommanderTest() {
        position_.xy_valid = position_.z_valid = true;
        position_.v_xy_valid = position_.v_z_valid = true;
        position_.x = 3.0F;
        land_.landed = true;
        result_.valid = true;
        sticks_.valid = true;
        switches_.mode_slot = 4;  // hold
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        battery_.connected = true;
        escs_ = {.esc_online_flags = 0b1111, .esc_count = 4};
    }

    void step() {
        now_us_ += 20'000;
        CommanderPorts ports{
            .now = now_us_,
            .position = Input(position_),
            .land = Input(land_),
            .progress = Input(progress_),
            .estimator = Input(estimator_),
            .result = Input(result_),
            .fence = Input(fence_),
            .sticks = has_sticks_ ? Input(sticks_) : Input<ManualControlSetpoint>(),
            .switches = Input(switches_),
            .battery = has_battery_ ? Input(battery_) : Input<BatteryStatus>(),
            .gyro = has_gyro_ ? Input(gyro_) : Input<SensorGyro>(),
            .mag = has_mag_ ? Input(mag_) : Input<SensorMag>(),
            .baro = has_baro_ ? Input(baro_) : Input<SensorBaro>(),
            .gnss = has_gnss_ ? Input(gnss_) : Input<SensorGps>(),
            .escs = Input(escs_),
            .command = is_commanded_ ? Input(command_) : Input<VehicleCommand>(),
            .offboard = Input(offboard_, has_setpoints_),
            .station = hears_station_ || has_heard_ ? Input(station_, hears_station_)
                                                    : Input<StationHeartbeat>(),
            .parameters = Input(parameters_),
            .allocation = Input(allocation_),
            .motors = has_motors_ ? Input(motors_) : Input<ActuatorMotors>(),
            .log = has_log_ ? Input(log_) : Input<LogBlock>(),
            .params = Input(params_)};
        testing::Probe status(ports.status, now_us_);
        testing::Probe home(ports.home, now_us_);
        testing::Probe health(ports.health, now_us_);
        testing::Probe accepted(ports.accepted, now_us_);
        testing::Probe ack(ports.ack, now_us_);
        testing::Probe motor_test(ports.motor_test, now_us_);
        node_.step(ports);
        has_heard_ = has_heard_ || hears_station_;
        if (is_commanded_) answer_ = ack.newest();
        is_passed_on_ = accepted.count() != 0;
        test_.reset();
        if (motor_test.count() != 0) test_ = motor_test.newest();
        is_commanded_ = false;
        status_ = status.newest();
        home_ = home.newest();
        health_ = health.newest();
    }
    void run(float seconds) {
        for (float t = 0.0F; t < seconds; t += 0.02F) step();
    }
    void set_arm_switch(bool on) {
        using Arm = ManualControlSwitches::ArmSwitch;
        switches_.arm_switch = on ? Arm::kOn : Arm::kOff;
        step();
    }
    // What becomes of a command.
    Answer command(const VehicleCommand& command) {
        command_ = command;
        command_.tag = ++tag_;
        is_commanded_ = true;
        step();
        EXPECT_EQ(answer_.tag, tag_);
        EXPECT_EQ(is_passed_on_, answer_.result == Answer::kAccepted);
        return answer_.result;
    }
    Answer command(Action action) { return command({.action = action}); }
    Answer command(Nav mode) {
        return command({.action = Action::kSetMode, .nav_state = static_cast<uint8_t>(mode)});
    }
    bool is_armed() const { return status_.arming_state == VehicleStatus::ArmingState::kArmed; }
    // Armed and in the air in this mode.
    void fly(Nav mode) {
        switches_.mode_slot = slot_of(mode);
        run(4.0F);
        set_arm_switch(true);
        ASSERT_TRUE(is_armed());
        land_.landed = false;
        step();
        ASSERT_EQ(status_.nav_state, mode);
    }
    void choose(Nav mode) {
        switches_.mode_slot = slot_of(mode);
        step();
    }
    // By the defaults of the parameters; take-off has no place of its own.
    uint8_t slot_of(Nav mode) {
        switch (mode) {
            case Nav::kStabilized:
                return 1;
            case Nav::kAltitude:
                return 2;
            case Nav::kPosition:
                return 3;
            case Nav::kHold:
                return 4;
            case Nav::kMission:
                return 5;
            case Nav::kLand:
                return 6;
            default:
                params_.mode6 = static_cast<int32_t>(mode);
                return 6;
        }
    }

    Commander node_;
    VehicleLocalPosition position_{};
    VehicleLandDetected land_{};
    TrajectoryProgress progress_{};
    EstimatorStatus estimator_{};
    MissionResult result_{};
    GeofenceResult fence_{};
    ManualControlSetpoint sticks_{};
    ManualControlSwitches switches_{};
    BatteryStatus battery_{};
    SensorGyro gyro_{};
    SensorMag mag_{};
    SensorBaro baro_{};
    SensorGps gnss_{};
    EscStatus escs_{};
    ActuatorMotors motors_{};
    bool has_motors_ = true;
    LogBlock log_{};
    ParameterStatus parameters_{};
    AllocationStatus allocation_{.motor_count = 4};
    std::optional<MotorTest> test_;  // of the last step
    CommanderParams params_{};
    VehicleStatus status_{};
    HomePosition home_{};
    HealthReport health_{};
    VehicleCommand command_{};
    VehicleCommandAck answer_{};
    OffboardSetpoint offboard_{};
    bool has_setpoints_ = false;  // new ones
    StationHeartbeat station_{};
    bool hears_station_ = false;
    bool has_heard_ = false;
    bool is_commanded_ = false;
    bool is_passed_on_ = false;
    uint8_t tag_ = 0;
    uint64_t now_us_ = 0;
    bool has_sticks_ = true;
    bool has_battery_ = true;
    bool has_gyro_ = true;
    bool has_mag_ = true;
    bool has_baro_ = true;
    bool has_gnss_ = true;
    bool has_log_ = true;
};

// --- arming ---

TEST_F(CommanderTest, arms_when_the_switch_goes_on_and_takes_home_from_there) {
    run(4.0F);
    EXPECT_TRUE(health_.can_arm);
    EXPECT_FALSE(is_armed());
    set_arm_switch(true);
    EXPECT_TRUE(is_armed());
    EXPECT_TRUE(home_.valid_lpos);
    EXPECT_EQ(home_.x, 3.0F);
}

TEST_F(CommanderTest, a_switch_that_was_on_from_the_start_does_not_arm) {
    switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOn;
    run(5.0F);
    EXPECT_FALSE(is_armed());
    set_arm_switch(false);
    set_arm_switch(true);
    EXPECT_TRUE(is_armed());
}

TEST_F(CommanderTest, each_check_that_fails_keeps_it_disarmed_and_says_so) {
    using Memory = ParameterStatus::State;
    const std::array<std::pair<std::function<void()>, bool HealthReport::*>, 18> faults{{
        {[&] { has_gyro_ = false; }, &HealthReport::sensors_ok},
        {[&] { has_mag_ = false; }, &HealthReport::sensors_ok},
        {[&] { has_baro_ = false; }, &HealthReport::sensors_ok},
        {[&] { has_gnss_ = false; }, &HealthReport::sensors_ok},
        {[&] { position_.xy_valid = false; }, &HealthReport::estimator_ok},
        {[&] { position_.z_valid = false; }, &HealthReport::estimator_ok},
        {[&] { position_.v_xy_valid = false; }, &HealthReport::estimator_ok},
        {[&] { position_.v_z_valid = false; }, &HealthReport::estimator_ok},
        {[&] { battery_.warning = Warning::kLow; }, &HealthReport::battery_ok},
        {[&] { battery_.connected = false; }, &HealthReport::battery_ok},
        {[&] { has_battery_ = false; }, &HealthReport::battery_ok},
        {[&] { escs_.esc_online_flags = 0b0111; }, &HealthReport::motors_ok},
        {[&] { has_sticks_ = false; }, &HealthReport::rc_ok},
        {[&] { has_log_ = false; }, &HealthReport::logging_ok},
        {[&] { parameters_.state = Memory::kLoading; }, &HealthReport::parameters_ok},
        {[&] { parameters_.state = Memory::kFailed; }, &HealthReport::parameters_ok},
        {[&] { parameters_.withheld = 1; }, &HealthReport::parameters_ok},
        {[&] { choose(Nav::kMission), result_.valid = false; }, &HealthReport::mission_ok},
    }};
    const VehicleLocalPosition good = position_;
    for (std::size_t i = 0; i < faults.size(); ++i) {
        node_ = {};
        position_ = good;
        parameters_ = {.state = Memory::kLoaded};
        battery_ = {.connected = true};
        escs_.esc_online_flags = 0b1111;
        has_sticks_ = has_battery_ = has_gyro_ = has_mag_ = has_baro_ = has_gnss_ = true;
        has_log_ = true;
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        run(4.0F);
        ASSERT_TRUE(health_.can_arm) << i;
        faults[i].first();
        set_arm_switch(true);
        EXPECT_FALSE(is_armed()) << i;
        EXPECT_FALSE(health_.can_arm) << i;
        EXPECT_FALSE(health_.*faults[i].second) << i;
    }
}

TEST_F(CommanderTest, the_estimate_must_have_been_good_for_a_while) {
    run(2.0F);
    EXPECT_FALSE(health_.estimator_ok);
    run(2.0F);
    EXPECT_TRUE(health_.estimator_ok);
}

TEST_F(CommanderTest, sensors_that_do_not_agree_keep_it_disarmed) {
    run(4.0F);
    ASSERT_TRUE(health_.estimator_ok);
    for (float EstimatorStatus::*ratio :
         {&EstimatorStatus::vel_test_ratio, &EstimatorStatus::pos_test_ratio,
          &EstimatorStatus::hgt_test_ratio, &EstimatorStatus::mag_test_ratio}) {
        estimator_.*ratio = 0.6F;
        step();
        EXPECT_FALSE(health_.estimator_ok);
        estimator_.*ratio = 0.1F;
        run(params_.settle_time - 0.1F);
        EXPECT_FALSE(health_.estimator_ok);
        run(0.2F);
        EXPECT_TRUE(health_.estimator_ok);
    }
}

TEST_F(CommanderTest, a_mission_is_only_needed_by_who_wants_to_fly_it) {
    result_.valid = false;
    run(4.0F);
    EXPECT_TRUE(health_.can_arm);
}

TEST_F(CommanderTest, the_switch_waits_for_checks_as_long_as_it_may) {
    params_.arming_wait = 2.0F;
    run(2.0F);
    set_arm_switch(true);
    EXPECT_FALSE(is_armed());
    run(1.5F);
    EXPECT_TRUE(is_armed());
}

TEST_F(CommanderTest, a_wish_that_waited_too_long_is_forgotten) {
    params_.arming_wait = 1.0F;
    step();
    set_arm_switch(true);
    run(10.0F);
    EXPECT_FALSE(is_armed());
}

TEST_F(CommanderTest, by_hand_it_arms_only_with_the_throttle_down) {
    choose(Nav::kStabilized);
    run(4.0F);
    set_arm_switch(true);
    EXPECT_FALSE(is_armed());
    set_arm_switch(false);
    sticks_.throttle = -1.0F;
    set_arm_switch(true);
    EXPECT_TRUE(is_armed());
}

// --- disarming ---

TEST_F(CommanderTest, the_switch_disarms_on_the_ground_and_not_in_the_air) {
    fly(Nav::kHold);
    set_arm_switch(false);
    EXPECT_TRUE(is_armed());
    set_arm_switch(true);
    land_.landed = true;
    set_arm_switch(false);
    EXPECT_FALSE(is_armed());
}

TEST_F(CommanderTest, the_kill_switch_disarms_in_the_air_once_it_is_held) {
    fly(Nav::kHold);
    switches_.kill_switch = ManualControlSwitches::KillSwitch::kOn;
    run(0.2F);
    EXPECT_TRUE(is_armed());
    run(0.2F);
    EXPECT_FALSE(is_armed());
    EXPECT_EQ(status_.nav_state, Nav::kTermination);
}

TEST_F(CommanderTest, after_a_landing_it_disarms) {
    fly(Nav::kLand);
    land_.landed = true;
    run(0.3F);
    EXPECT_TRUE(is_armed());
    run(0.4F);
    EXPECT_FALSE(is_armed());
}

TEST_F(CommanderTest, armed_without_a_take_off_it_disarms_after_a_while) {
    run(4.0F);
    set_arm_switch(true);
    run(params_.idle_limit - 1.0F);
    EXPECT_TRUE(is_armed());
    run(2.0F);
    EXPECT_FALSE(is_armed());
}

TEST_F(CommanderTest, a_failsafe_before_the_take_off_disarms) {
    run(4.0F);
    set_arm_switch(true);
    battery_.warning = Warning::kCritical;
    run(0.1F);
    EXPECT_FALSE(is_armed());
}

TEST_F(CommanderTest, a_descent_without_a_height_ends_when_the_last_one_must_be_gone) {
    fly(Nav::kHold);
    position_.z = -20.0F;
    step();
    position_.xy_valid = position_.z_valid = false;
    run(1.0F);
    ASSERT_EQ(status_.nav_state, Nav::kDescend);
    run(params_.blind_margin + 20.0F / params_.blind_sink - 3.0F);
    EXPECT_TRUE(is_armed());
    run(4.0F);
    EXPECT_FALSE(is_armed());
}

// A barometer alone sees that it is not.
TEST_F(CommanderTest, what_is_seen_high_up_is_not_down_by_now) {
    fly(Nav::kHold);
    position_.z = -20.0F;
    run(1.0F);
    position_.v_z_valid = false;
    run(600.0F);
    EXPECT_EQ(status_.nav_state, Nav::kDescend);
    EXPECT_TRUE(is_armed());
    position_.z = -5.0F;
    run(1.0F);
    EXPECT_FALSE(is_armed());
}

TEST_F(CommanderTest, a_descent_whose_height_is_known_ends_on_the_ground_alone) {
    fly(Nav::kHold);
    position_.z = -20.0F;
    position_.xy_valid = false;
    run(600.0F);
    EXPECT_EQ(status_.nav_state, Nav::kDescend);
    EXPECT_TRUE(is_armed());
    land_.landed = true;
    run(params_.disarm_after + 0.1F);
    EXPECT_FALSE(is_armed());
}

// --- on the ground ---

TEST_F(CommanderTest, landed_by_hand_each_lost_thing_disarms_and_leads_nowhere) {
    const std::array<std::function<void()>, 4> losses{
        [&] { sticks_.valid = false; }, [&] { position_.xy_valid = position_.z_valid = false; },
        [&] { battery_.warning = Warning::kCritical; }, [&] { escs_.esc_online_flags = 0b1011; }};
    for (const auto& lose : losses) {
        node_ = {};
        position_.xy_valid = position_.z_valid = sticks_.valid = true;
        battery_.warning = Warning::kNone;
        escs_.esc_online_flags = 0b1111;
        land_.landed = true;
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        fly(Nav::kPosition);
        land_.landed = true;
        run(params_.landed_time + 0.1F);
        ASSERT_TRUE(is_armed());
        lose();
        for (float t = 0.0F; t < 2.0F; t += 0.02F) {
            step();
            EXPECT_EQ(status_.nav_state, Nav::kPosition);
        }
        EXPECT_FALSE(is_armed());
    }
}

TEST_F(CommanderTest, what_only_just_landed_may_still_be_in_the_air) {
    fly(Nav::kPosition);
    land_.landed = true;
    run(0.5F * params_.landed_time);
    battery_.warning = Warning::kCritical;
    step();
    EXPECT_TRUE(is_armed());
    EXPECT_EQ(status_.nav_state, Nav::kLand);
}

TEST_F(CommanderTest, on_the_ground_the_return_switch_starts_nothing) {
    run(4.0F);
    set_arm_switch(true);
    switches_.return_switch = ManualControlSwitches::ReturnSwitch::kOn;
    run(1.0F);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
}

TEST_F(CommanderTest, a_crash_ends_it_in_the_air_and_on_the_ground) {
    for (const bool landed : {false, true}) {
        node_ = {};
        land_ = {.landed = true};
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        fly(Nav::kMission);
        land_.landed = landed;
        run(2.0F);
        land_.crashed = true;
        step();
        EXPECT_FALSE(is_armed());
        EXPECT_EQ(status_.failsafe_event, Event::kCrashed);
    }
}

TEST_F(CommanderTest, motors_that_nothing_commands_any_more_end_it) {
    for (const bool landed : {false, true}) {
        node_ = {};
        has_motors_ = true;
        land_ = {.landed = true};
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        fly(Nav::kMission);
        land_.landed = landed;
        run(2.0F);
        has_motors_ = false;
        step();
        EXPECT_FALSE(is_armed());
        EXPECT_FALSE(health_.motors_ok);
        EXPECT_EQ(status_.failsafe_event, Event::kCrashed);
    }
}

// --- modes ---

TEST_F(CommanderTest, the_mode_switch_chooses) {
    fly(Nav::kHold);
    for (const Nav mode : {Nav::kMission, Nav::kPosition, Nav::kAltitude, Nav::kStabilized}) {
        choose(mode);
        EXPECT_EQ(status_.nav_state, mode);
    }
}

TEST_F(CommanderTest, the_return_switch_goes_before_the_mode_switch) {
    fly(Nav::kHold);
    switches_.return_switch = ManualControlSwitches::ReturnSwitch::kOn;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
    choose(Nav::kMission);
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
    switches_.return_switch = ManualControlSwitches::ReturnSwitch::kOff;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kMission);
}

TEST_F(CommanderTest, what_has_come_to_its_end_leads_on) {
    fly(Nav::kMission);
    result_.finished = true;
    result_.nav_state = static_cast<uint8_t>(Nav::kMission);
    result_.next_nav_state = static_cast<uint8_t>(Nav::kReturn);
    step();
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
    step();  // what the mission said does not count for the return
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
}

TEST_F(CommanderTest, a_mode_that_could_not_go_on_is_refused) {
    sticks_.throttle = -1.0F;
    fly(Nav::kStabilized);
    position_.xy_valid = false;
    run(1.0F);
    EXPECT_EQ(status_.nav_state, Nav::kStabilized);
    choose(Nav::kMission);
    EXPECT_EQ(status_.nav_state, Nav::kStabilized);
    choose(Nav::kAltitude);
    EXPECT_EQ(status_.nav_state, Nav::kAltitude);
}

// --- failsafes ---

TEST_F(CommanderTest, lost_sticks_lead_home_after_a_moment) {
    fly(Nav::kMission);
    sticks_.valid = false;
    run(0.4F);
    EXPECT_EQ(status_.nav_state, Nav::kMission);
    run(0.2F);
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
    EXPECT_TRUE(status_.failsafe);
    EXPECT_EQ(status_.failsafe_event, Event::kRcLost);
}

TEST_F(CommanderTest, nothing_returns_by_itself_and_the_pilot_may_choose_again) {
    fly(Nav::kMission);
    sticks_.valid = false;
    run(1.0F);
    sticks_.valid = true;
    run(1.0F);
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
    choose(Nav::kHold);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
    EXPECT_FALSE(status_.failsafe);
}

TEST_F(CommanderTest, a_lost_position_leads_down) {
    fly(Nav::kMission);
    position_.v_xy_valid = false;
    run(1.0F);
    EXPECT_EQ(status_.nav_state, Nav::kDescend);
    EXPECT_EQ(status_.failsafe_event, Event::kPositionLost);
}

TEST_F(CommanderTest, a_lost_height_counts_before_a_lost_position) {
    fly(Nav::kMission);
    position_.z_valid = position_.xy_valid = false;
    run(1.0F);
    EXPECT_EQ(status_.failsafe_event, Event::kEstimatorInvalid);
}

TEST_F(CommanderTest, a_lost_motor_controller_leads_down_but_where_a_pilot_holds_the_attitude) {
    for (const Nav mode : {Nav::kMission, Nav::kHold, Nav::kReturn, Nav::kPosition}) {
        node_ = {};
        escs_.esc_online_flags = 0b1111;
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        land_.landed = true;
        if (mode == Nav::kReturn) {
            fly(Nav::kHold);
            choose(mode);
        } else {
            fly(mode);
        }
        escs_.esc_online_flags = 0b1011;
        step();
        EXPECT_EQ(status_.nav_state, Nav::kLand) << static_cast<int>(mode);
        EXPECT_EQ(status_.failsafe_event, Event::kMotorLost);
    }
    choose(Nav::kStabilized);
    run(1.0F);
    EXPECT_EQ(status_.nav_state, Nav::kStabilized);
    EXPECT_FALSE(health_.motors_ok);
}

TEST_F(CommanderTest, more_motor_controllers_than_there_are_flags_are_as_many_as_flags) {
    escs_ = {.esc_online_flags = 0xFFFF, .esc_count = 255};
    step();
    EXPECT_TRUE(health_.motors_ok);
    escs_.esc_online_flags = 0x7FFF;
    step();
    EXPECT_FALSE(health_.motors_ok);
}

TEST_F(CommanderTest, the_fence_turns_it_back) {
    for (bool GeofenceResult::*part :
         {&GeofenceResult::geofence_max_dist_triggered, &GeofenceResult::geofence_max_alt_triggered,
          &GeofenceResult::geofence_custom_fence_triggered}) {
        node_ = {};
        fence_ = {};
        land_.landed = true;
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        fly(Nav::kMission);
        EXPECT_EQ(status_.nav_state, Nav::kMission);
        fence_.*part = true;
        step();
        EXPECT_EQ(status_.nav_state, Nav::kReturn);
        EXPECT_EQ(status_.failsafe_event, Event::kGeofence);
    }
}

TEST_F(CommanderTest, a_low_battery_leads_home_and_a_critical_one_down_where_it_is) {
    fly(Nav::kMission);
    battery_.warning = Warning::kLow;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
    EXPECT_EQ(status_.failsafe_event, Event::kBatteryLow);
    battery_.warning = Warning::kEmergency;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kLand);
    EXPECT_EQ(status_.failsafe_event, Event::kBatteryCritical);
}

TEST_F(CommanderTest, a_battery_that_looks_better_again_does_not_count) {
    fly(Nav::kHold);
    battery_.warning = Warning::kLow;
    step();
    battery_.warning = Warning::kNone;
    choose(Nav::kPosition);
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
}

TEST_F(CommanderTest, a_lost_mission_leads_home_from_the_mission_alone) {
    fly(Nav::kHold);
    result_.valid = false;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kHold);
    result_.valid = true;
    choose(Nav::kMission);
    result_.valid = false;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
    EXPECT_EQ(status_.failsafe_event, Event::kMissionLost);
}

TEST_F(CommanderTest, a_landing_after_a_forced_return_is_forced_too) {
    fly(Nav::kMission);
    sticks_.valid = false;
    run(1.0F);
    result_.finished = true;
    result_.nav_state = static_cast<uint8_t>(Nav::kReturn);
    result_.next_nav_state = static_cast<uint8_t>(Nav::kLand);
    step();
    EXPECT_EQ(status_.nav_state, Nav::kLand);
    EXPECT_EQ(status_.failsafe_event, Event::kRcLost);
}

TEST_F(CommanderTest, what_cannot_follow_lands_where_it_is) {
    fly(Nav::kMission);
    progress_.lags_for = params_.lag_limit - 0.1F;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kMission);
    progress_.lags_for = params_.lag_limit;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kLand);
    EXPECT_EQ(status_.failsafe_event, Event::kCannotFollow);
}

// Whatever events come and go, a vehicle in the air stays armed, unless someone kills it.
TEST_F(CommanderTest, no_event_disarms_in_the_air) {
    for (unsigned events = 0; events < 64; ++events) {
        node_ = {};
        now_us_ = 0;
        position_.xy_valid = position_.z_valid = sticks_.valid = result_.valid = true;
        battery_.warning = Warning::kNone;
        land_.landed = true;
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        fence_ = {};
        fly(Nav::kMission);
        position_.xy_valid = (events & 1U) == 0;
        position_.z_valid = (events & 2U) == 0;
        sticks_.valid = (events & 4U) == 0;
        result_.valid = (events & 8U) == 0;
        if ((events & 16U) != 0) battery_.warning = Warning::kCritical;
        fence_.geofence_max_dist_triggered = (events & 32U) != 0;
        run(5.0F);
        EXPECT_TRUE(is_armed()) << events;
        EXPECT_EQ(status_.failsafe, events != 0) << events;
    }
}

// --- commands ---

TEST_F(CommanderTest, ArmsByCommandWhatTheChecksAllow) {
    EXPECT_EQ(command(Action::kArm), Answer::kTemporarilyRejected);  // the estimate is not settled
    run(4.0F);
    has_gnss_ = false;
    EXPECT_EQ(command(Action::kArm), Answer::kTemporarilyRejected);
    has_gnss_ = true;
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    EXPECT_TRUE(is_armed());
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    EXPECT_EQ(command(Action::kDisarm), Answer::kAccepted);
    EXPECT_FALSE(is_armed());
}

// The mode switch says mission; without one that is no reason, as another mode would be flown.
TEST_F(CommanderTest, AMissionThatIsMissingKeepsFromNothingButMissions) {
    result_.valid = false;
    switches_.mode_slot = slot_of(Nav::kMission);
    run(4.0F);
    EXPECT_FALSE(health_.can_arm);
    EXPECT_EQ(command(Nav::kMission), Answer::kTemporarilyRejected);
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
}

TEST_F(CommanderTest, TakesOffInEitherOrder) {
    run(4.0F);
    EXPECT_EQ(command(Nav::kTakeoff), Answer::kAccepted);
    EXPECT_FALSE(is_armed());
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    EXPECT_EQ(status_.nav_state, Nav::kTakeoff);
    EXPECT_EQ(command(Action::kDisarm), Answer::kAccepted);
    EXPECT_EQ(command(Nav::kHold), Answer::kAccepted);
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    EXPECT_EQ(command(Nav::kTakeoff), Answer::kAccepted);
    EXPECT_EQ(status_.nav_state, Nav::kTakeoff);
}

TEST_F(CommanderTest, DisarmsByCommandOnTheGroundOnly) {
    fly(Nav::kHold);
    EXPECT_EQ(command(Action::kDisarm), Answer::kTemporarilyRejected);
    EXPECT_TRUE(is_armed());
    EXPECT_EQ(command(Action::kKill), Answer::kAccepted);
    EXPECT_FALSE(is_armed());
    EXPECT_EQ(status_.nav_state, Nav::kTermination);
}

TEST_F(CommanderTest, ACommandCannotChooseWhatTheFailsafeTableRefuses) {
    fly(Nav::kHold);
    position_.xy_valid = false;
    run(1.0F);
    ASSERT_EQ(status_.nav_state, Nav::kDescend);
    EXPECT_EQ(command(Nav::kHold), Answer::kTemporarilyRejected);
    EXPECT_EQ(command(Action::kGo), Answer::kTemporarilyRejected);
    EXPECT_EQ(status_.nav_state, Nav::kDescend);
}

TEST_F(CommanderTest, NoCommandOfAReturnStartsAFlight) {
    run(4.0F);
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    EXPECT_EQ(command(Nav::kReturn), Answer::kTemporarilyRejected);
    EXPECT_EQ(command(Action::kGo), Answer::kTemporarilyRejected);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
}

TEST_F(CommanderTest, AFlightBeginsInHoldAfterOneThatLanded) {
    fly(Nav::kLand);
    land_.landed = true;
    run(5.0F);
    ASSERT_FALSE(is_armed());
    ASSERT_EQ(status_.nav_state, Nav::kLand);
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
}

TEST_F(CommanderTest, GoesFromAnyModeByHold) {
    fly(Nav::kMission);
    EXPECT_EQ(command(Action::kGo), Answer::kAccepted);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
    result_.seq_total = 3;
    EXPECT_EQ(command({.action = Action::kSetItem, .item = 2}), Answer::kAccepted);
    EXPECT_EQ(command({.action = Action::kSetItem, .item = 3}), Answer::kDenied);
}

TEST_F(CommanderTest, OffboardNeedsFreshSetpointsAndHoldsWithoutThem) {
    fly(Nav::kHold);
    EXPECT_EQ(command(Nav::kOffboard), Answer::kTemporarilyRejected);
    has_setpoints_ = true;
    run(0.1F);
    has_setpoints_ = false;
    run(0.7F);  // not two in a second
    EXPECT_EQ(command(Nav::kOffboard), Answer::kTemporarilyRejected);
    has_setpoints_ = true;
    EXPECT_EQ(command(Nav::kOffboard), Answer::kAccepted);
    has_setpoints_ = false;
    run(0.9F);
    EXPECT_EQ(status_.nav_state, Nav::kOffboard);
    run(0.2F);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
    EXPECT_EQ(status_.failsafe_event, Event::kOffboardLost);
    has_setpoints_ = true;
    run(1.0F);
    EXPECT_EQ(status_.nav_state, Nav::kHold);  // it does not go back by itself
}

TEST_F(CommanderTest, OffboardArmsOnTheGroundOnlyWithSetpoints) {
    has_setpoints_ = true;
    run(4.0F);
    EXPECT_EQ(command(Nav::kOffboard), Answer::kAccepted);
    has_setpoints_ = false;
    run(0.8F);
    EXPECT_EQ(command(Action::kArm), Answer::kTemporarilyRejected);
    has_setpoints_ = true;
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    has_setpoints_ = false;
    run(1.1F);
    EXPECT_FALSE(is_armed());
}

TEST_F(CommanderTest, AStationThatWasHeardAndFallsSilentIsLost) {
    params_.station_loss_action = 2;
    params_.station_timeout = 5.0F;
    fly(Nav::kHold);
    run(10.0F);
    EXPECT_EQ(status_.nav_state, Nav::kHold);  // none was there
    hears_station_ = true;
    run(1.0F);
    hears_station_ = false;
    run(4.9F);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
    run(0.3F);
    EXPECT_EQ(status_.nav_state, Nav::kReturn);
    EXPECT_EQ(status_.failsafe_event, Event::kStationLost);
}

TEST_F(CommanderTest, AStationThatIsLostTakesNoSticksAway) {
    params_.station_loss_action = 2;
    fly(Nav::kPosition);
    hears_station_ = true;
    step();
    hears_station_ = false;
    run(30.0F);
    EXPECT_EQ(status_.nav_state, Nav::kPosition);
}

TEST_F(CommanderTest, ActionsAreChosenByParameters) {
    struct Case {
        int32_t action;
        Nav mode;
    };
    for (const Case& c :
         {Case{1, Nav::kHold}, {2, Nav::kReturn}, {3, Nav::kLand}, {4, Nav::kReturn}}) {
        node_ = {};
        land_.landed = true;
        sticks_.valid = true;
        params_.rc_loss_action = c.action;
        switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOff;
        fly(Nav::kMission);
        sticks_.valid = false;
        run(1.0F);
        EXPECT_EQ(status_.nav_state, c.mode) << c.action;
        EXPECT_TRUE(is_armed());
    }
    params_.fence_action = 0;
    fence_.geofence_max_dist_triggered = true;
    sticks_.valid = true;
    ASSERT_EQ(command(Nav::kMission), Answer::kAccepted);
    run(1.0F);
    EXPECT_EQ(status_.nav_state, Nav::kMission);
    params_.fence_action = 4;
    run(0.1F);
    EXPECT_FALSE(is_armed());
}

class MotorTestTest : public CommanderTest {
  protected:
    MotorTestTest() {
        hears_station_ = true;
        run(0.1F);
    }
    Answer test(unsigned motor, float thrust, float duration = 1.0F) {
        return command({.action = Action::kTestMotor,
                        .motor = static_cast<uint8_t>(motor),
                        .thrust = thrust,
                        .duration = duration});
    }
    // That the last step stopped it, and nothing follows.
    void expect_end() {
        ASSERT_TRUE(test_);
        EXPECT_TRUE(math::is_nan(test_->thrust));
        step();
        EXPECT_FALSE(test_);
    }
};

TEST_F(MotorTestTest, a_motor_turns_for_its_time) {
    EXPECT_EQ(test(2, 0.15F, 0.5F), Answer::kAccepted);
    for (int i = 0; i < 25; ++i) {
        ASSERT_TRUE(test_) << i;
        if (math::is_nan(test_->thrust)) break;
        EXPECT_EQ(test_->motor, 2);
        EXPECT_EQ(test_->thrust, 0.15F);
        EXPECT_LT(i, 25);
        step();
    }
    expect_end();
}

TEST_F(MotorTestTest, the_newest_takes_the_place_of_the_one_before_and_nan_ends_it) {
    EXPECT_EQ(test(0, 0.1F), Answer::kAccepted);
    EXPECT_EQ(test(3, 0.2F), Answer::kAccepted);
    EXPECT_EQ(test_->motor, 3);
    EXPECT_EQ(test(3, math::canonical_nan<float>()), Answer::kAccepted);
    expect_end();
}

TEST_F(MotorTestTest, what_cannot_be_tested_is_denied) {
    EXPECT_EQ(test(4, 0.1F), Answer::kDenied);
    EXPECT_EQ(test(0, -0.1F), Answer::kDenied);
    EXPECT_EQ(test(0, 1.1F), Answer::kDenied);
    EXPECT_EQ(test(0, 0.1F, 0.0F), Answer::kDenied);
    EXPECT_EQ(test(0, 0.1F, 11.0F), Answer::kDenied);
    EXPECT_EQ(test(0, 0.1F, math::canonical_nan<float>()), Answer::kDenied);
    EXPECT_FALSE(test_);
}

TEST_F(MotorTestTest, only_on_the_ground_disarmed_and_while_a_station_is_heard) {
    land_.landed = false;
    EXPECT_EQ(test(0, 0.1F), Answer::kTemporarilyRejected) << "falls, disarmed";
    land_.landed = true;
    hears_station_ = false;
    run(3.0F);
    EXPECT_EQ(test(0, 0.1F), Answer::kTemporarilyRejected) << "nobody is there";
    hears_station_ = true;
    fly(Nav::kHold);
    EXPECT_EQ(test(0, 0.1F), Answer::kTemporarilyRejected) << "in the air";
    EXPECT_FALSE(test_);
}

TEST_F(MotorTestTest, ends_when_the_station_is_lost) {
    EXPECT_EQ(test(0, 0.1F, 10.0F), Answer::kAccepted);
    hears_station_ = false;
    run(2.0F);
    ASSERT_TRUE(test_);
    EXPECT_EQ(test_->thrust, 0.1F);
    run(1.0F);
    EXPECT_FALSE(test_);
    hears_station_ = true;
    run(1.0F);
    EXPECT_FALSE(test_) << "nothing begins again";
}

TEST_F(MotorTestTest, ends_by_arming_and_by_the_kill_switch) {
    run(4.0F);
    EXPECT_EQ(test(0, 0.1F, 10.0F), Answer::kAccepted);
    EXPECT_EQ(command(Action::kArm), Answer::kAccepted);
    EXPECT_TRUE(is_armed());
    expect_end();
    EXPECT_EQ(command(Action::kDisarm), Answer::kAccepted);
    EXPECT_EQ(test(0, 0.1F, 10.0F), Answer::kAccepted);
    switches_.kill_switch = ManualControlSwitches::KillSwitch::kOn;
    step();
    expect_end();
}

}  // namespace
}  // namespace stator::apps::commander
