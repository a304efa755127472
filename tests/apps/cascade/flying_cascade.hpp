// For tests of the control loop: the five control nodes in cascade around a plain rigid body with
// lagging motors, whose state they are told exactly, the position late. Data: PX4's Gazebo Iris.
// The parameters are the interfaces' defaults, which are for it: their tuning is tested too.
#pragma once

#include <array>
#include <deque>
#include <ostream>

#include "allocation.hpp"
#include "attitude_control.hpp"
#include "position_control.hpp"
#include "rate_control.hpp"
#include "sequence.hpp"
#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::testing {

using Vector = math::Vector3<double>;

struct BodyState {
    Vector position_N = Vector::Zero();
    Vector velocity_N = Vector::Zero();
    math::Quaternion<double> q_NB = math::Quaternion<double>::Identity();
    Vector rate_B = Vector::Zero();
};

// What may differ between the vehicle and what the parameters say.
struct Mismatch {
    const char* name = "nominal";
    double mass = 1.0;                 // factor
    double inertia = 1.0;              // factor
    double thrust = 1.0;               // factor
    Vector torque_B = Vector::Zero();  // N*m, constant
    double gyro_noise = 0.0;           // rad/s per sample
    uint64_t position_delay_us = 10'000;
    uint64_t seed = 1;
};
// The name by which GoogleTest prints it.
inline void PrintTo(const Mismatch& mismatch, std::ostream* out) {
    *out << mismatch.name;
}

class IrisBody {
  public:
    explicit IrisBody(const Mismatch& mismatch) : mismatch_(mismatch) {}

    // Motor commands as in ActuatorMotors. Semi-implicit Euler; the ground holds what rests on it.
    void advance(const std::array<float, 12>& control, double dt) {
        Vector force_B = Vector::Zero();
        Vector torque_B = mismatch_.torque_B;
        for (unsigned i = 0; i < 4; ++i) {
            const double thrust = motor_thrust(i, control[i], dt);
            force_B.z() -= thrust;
            torque_B +=
                Vector(-kRotors[i].y * thrust, kRotors[i].x * thrust, kRotors[i].moment * thrust);
        }
        move(force_B, torque_B, dt);
        if (is_on_ground() && state.velocity_N.z() >= 0.0) rest();
    }

    bool is_on_ground() const { return state.position_N.z() >= 0.0; }
    double touchdown_speed() const { return touchdown_speed_; }
    void start_hovering() { speed_.fill(803.0); }

    BodyState state;

  private:
    struct Place {
        double x, y, moment;
    };
    static constexpr std::array<Place, 4> kRotors{
        {{0.13, 0.22, 0.06}, {-0.13, -0.20, 0.06}, {0.13, -0.22, -0.06}, {-0.13, 0.20, -0.06}}};
    static constexpr double kMass = 1.535;
    static constexpr double kThrustConstant = 5.84e-6;
    static constexpr double kFastest = 1100.0;
    static constexpr double kLagUp = 0.0125;
    static constexpr double kLagDown = 0.025;

    double motor_thrust(unsigned i, float control, double dt) {
        const double command = control >= 0.0F ? static_cast<double>(control) : 0.0;
        const double wanted = kFastest * math::sqrt(command);
        const double lag = wanted > speed_[i] ? kLagUp : kLagDown;
        speed_[i] += (wanted - speed_[i]) * dt / lag;
        return mismatch_.thrust * kThrustConstant * speed_[i] * speed_[i];
    }
    void move(const Vector& force_B, const Vector& torque_B, double dt) {
        const Vector inertia = mismatch_.inertia * Vector(0.029125, 0.029125, 0.055225);
        const Vector momentum = inertia.cwiseProduct(state.rate_B);
        const Vector gyroscopic = state.rate_B.cross(momentum);
        state.rate_B += (torque_B - gyroscopic).cwiseQuotient(inertia) * dt;
        state.q_NB = math::integrate(state.q_NB, state.rate_B, dt);
        const Vector acceleration =
            state.q_NB.toRotationMatrix() * force_B / (mismatch_.mass * kMass) +
            Vector(0.0, 0.0, 9.80665);
        state.velocity_N += acceleration * dt;
        state.position_N += state.velocity_N * dt;
    }
    void rest() {
        touchdown_speed_ = math::max(touchdown_speed_, state.velocity_N.z());
        state.position_N.z() = 0.0;
        state.velocity_N.setZero();
        state.rate_B.setZero();
        state.q_NB =
            math::normalized(math::Quaternion<double>(state.q_NB.w(), 0.0, 0.0, state.q_NB.z()));
    }

    Mismatch mismatch_;
    std::array<double, 4> speed_{};
    double touchdown_speed_ = 0.0;
};

// Runs rate control and allocation at 1 kHz, attitude control at 250 Hz, position control at
// 100 Hz. `trajectory` and `status` are the test's, or the sequence's if `run_sequence`.
class FlyingCascade {
  public:
    explicit FlyingCascade(const Mismatch& mismatch = {})
        : body(mismatch), mismatch_(mismatch), random_(mismatch.seed) {
        status.arming_state = VehicleStatus::ArmingState::kArmed;
        status.nav_state = VehicleStatus::NavState::kHold;
    }

    // In the air, long enough for spool-up and the drop that it causes to be over.
    void start_hovering(double height) {
        body.state.position_N.z() = -height;
        body.start_hovering();
        hold_position({0.0F, 0.0F, static_cast<float>(-height)});
        for (int i = 0; i < 20'000; ++i) step();
    }
    void hold_position(const std::array<float, 3>& position_N, float yaw = 0.0F) {
        trajectory = {};
        trajectory.position = position_N;
        trajectory.yaw = yaw;
    }

    void step() {
        now_us_ += 1000;
        remember();
        if (run_sequence && now_us_ % 20'000 == 0) step_sequence();
        if (control_position && now_us_ % 10'000 == 0) step_position();
        step_rate();
        if (now_us_ % 4'000 == 0) step_attitude();
        body.advance(motors, 1e-3);
    }
    double seconds() const { return static_cast<double>(now_us_) * 1e-6; }

    IrisBody body;
    TrajectorySetpoint trajectory{};
    VehicleStatus status{};
    VehicleAttitudeSetpoint attitude_setpoint{};
    std::array<float, 12> motors{};
    bool run_sequence = false;
    bool control_position = true;
    bool position_is_valid = true;

    SequenceParams sequence_params;

  private:
    void remember() {
        VehicleLocalPosition p{};
        const BodyState& s = body.state;
        p.timestamp_sample = now_us_;
        p.x = static_cast<float>(s.position_N.x());
        p.y = static_cast<float>(s.position_N.y());
        p.z = static_cast<float>(s.position_N.z());
        p.vx = static_cast<float>(s.velocity_N.x());
        p.vy = static_cast<float>(s.velocity_N.y());
        p.vz = static_cast<float>(s.velocity_N.z());
        p.heading = static_cast<float>(math::heading(s.q_NB));
        p.xy_valid = p.z_valid = p.v_xy_valid = p.v_z_valid = position_is_valid;
        late_.push_back(p);
        while (late_.front().timestamp_sample + mismatch_.position_delay_us < now_us_) {
            late_.pop_front();
        }
        position_ = late_.front();
    }
    void step_sequence() {
        apps::sequence::SequencePorts ports{
            .now = now_us_, .position = Input(position_), .params = Input(sequence_params)};
        Probe trajectory_probe(ports.setpoint, now_us_);
        Probe status_probe(ports.status, now_us_);
        sequence_.step(ports);
        trajectory = trajectory_probe.newest();
        status = status_probe.newest();
    }
    void step_position() {
        apps::position_control::PositionControlPorts ports{
            .now = now_us_,
            .position = Input(position_),
            .setpoint = Input(trajectory),
            .status = Input(status),
            .params = Input(position_params_, is_first_position_)};
        is_first_position_ = false;
        Probe probe(ports.attitude_setpoint, now_us_);
        position_control_.step(ports);
        attitude_setpoint = probe.newest();
    }
    void step_attitude() {
        VehicleAttitude attitude{};
        const math::Quaternion<float> q = body.state.q_NB.cast<float>();
        attitude.timestamp_sample = now_us_;
        attitude.q = math::to_array(q);
        apps::attitude_control::AttitudeControlPorts ports{.now = now_us_,
                                                           .attitude = Input(attitude),
                                                           .setpoint = Input(attitude_setpoint),
                                                           .params = Input(attitude_params_)};
        Probe probe(ports.rates, now_us_);
        attitude_control_.step(ports);
        rates_setpoint_ = probe.newest();
    }
    void step_rate() {
        SensorGyro gyro{};
        gyro.timestamp_sample = now_us_;
        for (unsigned i = 0; i < 3; ++i) {
            const double noise = mismatch_.gyro_noise * random_.gaussian_double();
            gyro.xyz[i] = static_cast<float>(body.state.rate_B[static_cast<int>(i)] + noise);
        }
        apps::rate_control::RateControlPorts ports{.now = now_us_,
                                                   .gyro = Input(gyro),
                                                   .setpoint = Input(rates_setpoint_),
                                                   .status = Input(status),
                                                   .params = Input(rate_params_, is_first_rate_)};
        Probe thrust(ports.thrust, now_us_);
        Probe torque(ports.torque, now_us_);
        rate_control_.step(ports);
        allocate(torque.newest(), thrust.newest());
    }
    void allocate(const VehicleTorqueSetpoint& torque, const VehicleThrustSetpoint& thrust) {
        apps::allocation::AllocationPorts ports{
            .now = now_us_,
            .torque = Input(torque),
            .thrust = Input(thrust),
            .status = Input(status),
            .params = Input(allocation_params_, is_first_rate_)};
        is_first_rate_ = false;
        Probe probe(ports.motors, now_us_);
        allocation_.step(ports);
        motors = probe.newest().control;
    }

    Mismatch mismatch_;
    math::Random random_;
    uint64_t now_us_ = 0;
    std::deque<VehicleLocalPosition> late_;
    VehicleLocalPosition position_{};
    VehicleRatesSetpoint rates_setpoint_{};
    bool is_first_position_ = true;
    bool is_first_rate_ = true;

    apps::sequence::Sequence sequence_;
    apps::position_control::PositionControl position_control_;
    apps::attitude_control::AttitudeControl attitude_control_;
    apps::rate_control::RateControl rate_control_;
    apps::allocation::Allocation allocation_;
    PositionControlParams position_params_;
    AttitudeControlParams attitude_params_;
    RateControlParams rate_params_;
    AllocationParams allocation_params_;
};

}  // namespace stator::testing
