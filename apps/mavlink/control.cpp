// What stations steer with.
#include "control.hpp"

#include "stator/rotation.hpp"

namespace stator::apps::mavlink {

namespace {

using Triple = std::array<float, 3>;

constexpr float kNan = math::canonical_nan<float>();
constexpr Triple kFree{kNan, kNan, kNan};
constexpr int kFullStick = 1000;
constexpr float kFarthest = 1e6F;  // m, or m/s: beyond it a number is a mistake

// Bits of the mask of a position: what is not given.
constexpr unsigned kVelocity = 3;      // its first bit; x, y and z follow
constexpr unsigned kAcceleration = 6;  // the same
constexpr uint32_t kForce = 1U << 9;
constexpr uint32_t kYaw = 1U << 10;
constexpr uint32_t kYawRate = 1U << 11;
// The same of an attitude.
constexpr uint32_t kNoRollRate = 1U << 0;
constexpr uint32_t kNoPitchRate = 1U << 1;
constexpr uint32_t kNoYawRate = 1U << 2;
constexpr uint32_t kNoThrust = 1U << 6;
constexpr uint32_t kNoAttitude = 1U << 7;

bool is_usable(float value) {
    return math::abs(value) < kFarthest;  // not a number is not
}

// Three numbers, of which the mask says from `first` on which are not given. False: one that is
// given is not usable.
bool take(Triple& into, const Triple& from, uint32_t mask, unsigned first) {
    into = kFree;
    for (unsigned axis = 0; axis < 3; ++axis) {
        if ((mask >> (first + axis) & 1U) != 0) continue;
        if (!is_usable(from[axis])) return false;
        into[axis] = from[axis];
    }
    return true;
}

// The fields that a local and a global target share.
template <class Target>
std::optional<OffboardSetpoint> motion_of(const Target& target, const Triple& position) {
    const uint32_t mask = target.type_mask;
    OffboardSetpoint result{.kind = OffboardSetpoint::Kind::kMotion, .yaw = kNan, .yawspeed = kNan};
    if ((mask & kForce) != 0) return {};
    const bool are_usable =
        take(result.position, position, mask, 0) &&
        take(result.velocity, {target.vx, target.vy, target.vz}, mask, kVelocity) &&
        take(result.acceleration, {target.afx, target.afy, target.afz}, mask, kAcceleration);
    if (!are_usable) return {};
    if ((mask & kYaw) == 0) {
        if (!is_usable(target.yaw)) return {};
        result.yaw = math::wrap_pi(target.yaw);
    }
    if ((mask & kYawRate) == 0) {
        if (!is_usable(target.yaw_rate)) return {};
        result.yawspeed = target.yaw_rate;
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        const bool is_free = math::is_nan(result.position[axis]) &&
                             math::is_nan(result.velocity[axis]) &&
                             math::is_nan(result.acceleration[axis]);
        if (is_free) return {};
    }
    return result;
}

// From ahead, right and down of the vehicle to N.
Triple turned(const Triple& v, float heading) {
    const auto [sin, cos] = math::sincos(heading);
    return {cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]};
}

}  // namespace

bool Control::Sender::takes(unsigned line, mav::Address from, uint64_t now_us) {
    const bool is_it = from_ == from && line_ == line;
    if (!is_it && heard_us_ != 0 && now_us - heard_us_ < kSilent_us) return false;
    line_ = line;
    from_ = from;
    heard_us_ = now_us;
    return true;
}

// An axis that the sender does not have makes the message unusable.
void Control::take_sticks(const mav::ManualControl& control, uint64_t now_us) {
    const auto is_stick = [](int value) { return value >= -kFullStick && value <= kFullStick; };
    if (!is_stick(control.x) || !is_stick(control.y) || !is_stick(control.r)) return;
    if (control.z < 0 || control.z > kFullStick) return;
    const auto stick = [](int value) {
        return static_cast<float>(value) / static_cast<float>(kFullStick);
    };
    sticks_ = ManualControlSetpoint{.timestamp_sample = now_us,
                                    .valid = true,
                                    .roll = stick(control.y),
                                    .pitch = stick(control.x),
                                    .yaw = stick(control.r),
                                    .throttle = 2.0F * stick(control.z) - 1.0F};
}

void Control::take_position(const mav::SetPositionTargetLocalNed& target,
                            const MavlinkPorts& ports) {
    namespace frames = mav::mav_frame;
    const uint8_t frame = target.coordinate_frame;
    const bool is_offset = frame == frames::kLocalOffsetNed || frame == frames::kBodyOffsetNed;
    const bool is_body =
        frame == frames::kBodyNed || frame == frames::kBodyOffsetNed || frame == frames::kBodyFrd;
    auto wanted = motion_of(target, {target.x, target.y, target.z});
    if (!wanted || (frame != frames::kLocalNed && !is_offset && !is_body)) return;
    if (frame != frames::kLocalNed) {
        // Of a place that moves along with the vehicle, nothing is held: speeds alone.
        const bool has_place = math::is_finite(wanted->position[0]) ||
                               math::is_finite(wanted->position[1]) ||
                               math::is_finite(wanted->position[2]);
        if (has_place || (is_body && !ports.position)) return;
    }
    if (is_body) {
        // With both parts or none: a free part has no direction.
        wanted->velocity = turned(wanted->velocity, ports.position->heading);
        wanted->acceleration = turned(wanted->acceleration, ports.position->heading);
        if (math::is_nan(wanted->velocity[0]) && math::is_nan(wanted->acceleration[0])) return;
    }
    setpoint_ = wanted;
}

void Control::take_global(const mav::SetPositionTargetGlobalInt& target,
                          const Telemetry& telemetry) {
    namespace frames = mav::mav_frame;
    const uint8_t frame = target.coordinate_frame;
    const bool is_relative =
        frame == frames::kGlobalRelativeAlt || frame == frames::kGlobalRelativeAltInt;
    const bool is_known = is_relative || frame == frames::kGlobal || frame == frames::kGlobalInt;
    if (!is_known || !telemetry.knows_earth()) return;
    const auto at = telemetry.frame().to_local(
        {static_cast<double>(target.lat_int) * 1e-7, static_cast<double>(target.lon_int) * 1e-7});
    const float from = is_relative ? telemetry.home_down() : telemetry.reference_altitude();
    const Triple position{static_cast<float>(at.north), static_cast<float>(at.east),
                          from - target.alt};
    if (const auto wanted = motion_of(target, position)) setpoint_ = wanted;
}

void Control::take_attitude(const mav::SetAttitudeTarget& target) {
    const uint32_t mask = target.type_mask;
    const bool has_thrust =
        (mask & kNoThrust) == 0 && target.thrust >= 0.0F && target.thrust <= 1.0F;
    if (!has_thrust) return;
    OffboardSetpoint wanted{.yaw = kNan, .yawspeed = 0.0F, .thrust = target.thrust};
    if ((mask & kNoAttitude) == 0) {
        const auto& q = target.q;
        const float norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        if (!(norm2 > 0.5F && norm2 < 2.0F)) return;
        wanted.kind = OffboardSetpoint::Kind::kAttitude;
        wanted.q_d = math::to_array(math::normalized(math::quaternion(q)));
        if ((mask & kNoYawRate) == 0) wanted.yawspeed = target.body_yaw_rate;
        if (!is_usable(wanted.yawspeed)) return;
    } else {
        if ((mask & (kNoRollRate | kNoPitchRate | kNoYawRate)) != 0) return;
        wanted.kind = OffboardSetpoint::Kind::kRates;
        wanted.rates = {target.body_roll_rate, target.body_pitch_rate, target.body_yaw_rate};
        for (const float rate : wanted.rates) {
            if (!is_usable(rate)) return;
        }
    }
    setpoint_ = wanted;
}

bool Control::handle(const Link& link, unsigned line, const mav::Frame& frame,
                     const Telemetry& telemetry, const MavlinkPorts& ports) {
    const mav::Address own = link.own();
    const auto is_for_us = [own](const auto& message) {
        return (message.target_system == 0 || message.target_system == own.system) &&
               (message.target_component == 0 || message.target_component == own.component);
    };
    const bool may_steer = link.allows(Right::kSteer);
    const auto sends_setpoints = [&] {
        return may_steer && companion_.takes(line, frame.source, ports.now);
    };
    switch (frame.id) {
        case mav::Heartbeat::kId: {
            const auto beat = mav::decode<mav::Heartbeat>(frame.payload);
            if (beat.type != mav::mav_type::kGcs || frame.source.system == own.system) return true;
            station_ = StationHeartbeat{.system_id = frame.source.system,
                                        .line = static_cast<uint8_t>(line + 1)};
            return true;
        }
        case mav::ManualControl::kId: {
            const auto control = mav::decode<mav::ManualControl>(frame.payload);
            if (control.target != own.system || !may_steer) return true;
            if (pilot_.takes(line, frame.source, ports.now)) take_sticks(control, ports.now);
            return true;
        }
        case mav::SetPositionTargetLocalNed::kId: {
            const auto target = mav::decode<mav::SetPositionTargetLocalNed>(frame.payload);
            if (is_for_us(target) && sends_setpoints()) take_position(target, ports);
            return true;
        }
        case mav::SetPositionTargetGlobalInt::kId: {
            const auto target = mav::decode<mav::SetPositionTargetGlobalInt>(frame.payload);
            if (is_for_us(target) && sends_setpoints()) take_global(target, telemetry);
            return true;
        }
        case mav::SetAttitudeTarget::kId: {
            const auto target = mav::decode<mav::SetAttitudeTarget>(frame.payload);
            if (is_for_us(target) && sends_setpoints()) take_attitude(target);
            return true;
        }
        default:
            return false;
    }
}

void Control::publish(MavlinkPorts& ports) {
    if (station_) ports.station.publish([&] { return *station_; });
    if (sticks_) ports.station_sticks.publish([&] { return *sticks_; });
    if (setpoint_) ports.offboard.publish([&] { return *setpoint_; });
    station_.reset();
    sticks_.reset();
    setpoint_.reset();
}

}  // namespace stator::apps::mavlink
