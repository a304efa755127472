// Total energy control.
#include "energy_control.hpp"

#include "stator/scalar.hpp"

namespace stator::apps::tecs {

namespace {

constexpr float kGravity = 9.80665F;
constexpr float kReferenceTime = 2.0F;          // s, in which the reference comes to rest
constexpr float kReferenceAcceleration = 2.0F;  // m/s^2
constexpr float kStallMargin = 1.05F;           // all energy goes to speed from here down
constexpr float kSpeedShare = 0.5F;             // of the energy rate that speed may ask for

float or_else(float value, float fallback) {
    return math::is_finite(value) ? value : fallback;
}

}  // namespace

void EnergyControl::start(const Motion& motion, const TecsParams& params) {
    const float speed = or_else(motion.airspeed, params.trim_airspeed);
    reference_ = motion.height;
    reference_rate_ = motion.height_rate;
    energy_rate_ = 0.0F;
    if (!is_running_) status_.throttle_integ = 0.0F;
    // In a steady climb the pitch exceeds the climb angle by the angle of attack.
    status_.pitch_integ = motion.pitch - motion.height_rate / math::max(speed, 1.0F);
    status_.pitch_sp_rad = motion.pitch;
    is_running_ = true;
}

// Not a number: the height is free.
float EnergyControl::height_rate_for(const Motion& motion, const Wanted& wanted,
                                     const TecsParams& params, float dt) {
    if (math::is_finite(wanted.height_rate)) {
        reference_ = motion.height;
        reference_rate_ = wanted.height_rate;
        return math::clamp(wanted.height_rate, -params.climb_max, params.climb_max);
    }
    if (!math::is_finite(wanted.height)) {
        reference_ = motion.height;
        reference_rate_ = motion.height_rate;
        return math::canonical_nan<float>();
    }
    const float rate = math::clamp((wanted.height - reference_) / kReferenceTime,
                                   -params.sink_target, params.climb_target);
    const float most = kReferenceAcceleration * dt;
    reference_rate_ += math::clamp(rate - reference_rate_, -most, most);
    reference_ += reference_rate_ * dt;
    const float corrected =
        (reference_ - motion.height) / params.height_time + params.height_ff * reference_rate_;
    return math::clamp(corrected, -params.climb_max, params.climb_max);
}

void EnergyControl::set_throttle(float wanted, float rate, float underspeed,
                                 const TecsParams& params, float dt) {
    const float most = kGravity * params.climb_max;
    const float least = -kGravity * params.sink_min;
    wanted = math::clamp(wanted, least, most);
    energy_rate_ += (rate - energy_rate_) * (dt / (params.energy_rate_time + dt));
    const float forward =
        params.throttle_trim +
        (wanted >= 0.0F ? wanted / most * (params.throttle_max - params.throttle_trim)
                        : wanted / least * (params.throttle_min - params.throttle_trim));
    const float per_rate = (params.throttle_max - params.throttle_min) / (most - least);
    const float error = per_rate * (wanted - energy_rate_);
    float throttle = forward + params.throttle_damping * error + status_.throttle_integ;
    throttle += underspeed * (params.throttle_max - throttle);
    const float limited = math::clamp(throttle, params.throttle_min, params.throttle_max);
    const bool winds_up = (throttle - limited) * error > 0.0F || underspeed > 0.0F;
    if (!winds_up) {
        status_.throttle_integ = math::clamp(
            status_.throttle_integ + params.throttle_integral * error * dt, -0.5F, 0.5F);
    }
    status_.throttle_sp = limited;
    status_.total_energy_rate_sp = wanted;
    status_.total_energy_rate = energy_rate_;
}

void EnergyControl::set_pitch(float wanted, float rate, float speed, const TecsParams& params,
                              float dt) {
    const float per_rate = 1.0F / (speed * kGravity);
    const float error = per_rate * (wanted - rate);
    const float pitch = per_rate * wanted + params.pitch_damping * error + status_.pitch_integ;
    const float limited = math::clamp(pitch, params.pitch_min, params.pitch_max);
    const bool winds_up = (pitch - limited) * error > 0.0F;
    if (!winds_up) status_.pitch_integ += params.pitch_integral * error * dt;
    const float most = params.vertical_acceleration / speed * dt;
    status_.pitch_sp_rad += math::clamp(limited - status_.pitch_sp_rad, -most, most);
    status_.energy_balance_rate_sp = wanted;
    status_.energy_balance_rate = rate;
}

void EnergyControl::update(const Motion& motion, const Wanted& wanted, const TecsParams& params,
                           float dt) {
    if (!is_running_) start(motion, params);
    const bool knows_speed = math::is_finite(motion.airspeed);
    const float tas = motion.tas_over_eas;
    const float speed =
        math::max(or_else(motion.airspeed, tas * params.trim_airspeed), params.min_airspeed / 2.0F);
    const float root_n = math::sqrt(motion.load_factor);
    const float slowest = tas * params.min_airspeed * root_n;
    const float stall = tas * kStallMargin * params.stall_airspeed * root_n;
    const float underspeed =
        knows_speed ? math::clamp((slowest - speed) / math::max(slowest - stall, 0.1F), 0.0F, 1.0F)
                    : 0.0F;

    const float wanted_rate = height_rate_for(motion, wanted, params, dt);
    const bool is_height_free = !math::is_finite(wanted_rate);
    const float wanted_speed = math::clamp(or_else(wanted.airspeed, tas * params.trim_airspeed),
                                           slowest, tas * params.max_airspeed);
    const float wanted_gain = knows_speed
                                  ? math::clamp((wanted_speed - speed) / params.airspeed_time,
                                                -kSpeedShare * kGravity * params.sink_min / speed,
                                                kSpeedShare * kGravity * params.climb_max / speed)
                                  : 0.0F;
    const float speed_rate = knows_speed ? speed * motion.airspeed_rate : 0.0F;
    const float wanted_speed_rate = speed * wanted_gain;
    const float height_rate = kGravity * motion.height_rate;
    const float wanted_height_rate = kGravity * or_else(wanted_rate, motion.height_rate);

    float weight = knows_speed ? params.speed_weight : 0.0F;
    if (is_height_free && knows_speed) weight = 2.0F;
    weight += underspeed * (2.0F - weight);
    const float of_speed = math::min(weight, 1.0F);
    const float of_height = math::min(2.0F - weight, 1.0F);

    const float turn = params.roll_to_throttle * (motion.load_factor - 1.0F);
    set_throttle(wanted_height_rate + wanted_speed_rate + turn, height_rate + speed_rate,
                 underspeed, params, dt);
    set_pitch(of_height * wanted_height_rate - of_speed * wanted_speed_rate,
              of_height * height_rate - of_speed * speed_rate, speed, params, dt);
    if (math::is_finite(wanted.throttle)) {
        status_.throttle_sp = math::clamp(wanted.throttle, 0.0F, params.throttle_max);
    }
    if (math::is_finite(wanted.pitch)) {
        const float before = status_.throttle_sp;
        start(motion, params);
        status_.throttle_sp = before;
        status_.pitch_sp_rad = math::clamp(wanted.pitch, params.pitch_min, params.pitch_max);
    }
    status_.altitude_reference = reference_;
    status_.height_rate_reference = wanted_rate;
    status_.height_rate = motion.height_rate;
    status_.true_airspeed_sp = wanted_speed;
    status_.true_airspeed_filtered = motion.airspeed;
    status_.true_airspeed_derivative = motion.airspeed_rate;
    status_.underspeed_ratio = underspeed;
    status_.speed_weight = weight;
}

}  // namespace stator::apps::tecs
