// Navigation: what the filter does with each measurement once its time has come.
#include <type_traits>

#include "navigation.hpp"

namespace stator::apps::navigation {

namespace {

// The horizon has passed it by more than a step can make up for.
constexpr float kTooLate = 0.1F;  // s
// Without satellites, or at rest, the velocity is measured as zero: well at rest, hardly in flight,
// where it only keeps the tilt with gravity.
constexpr uint64_t kRestInterval_us = 200'000;
constexpr float kRestVariance = 0.01F;  // m^2/s^2
constexpr float kFlightVariance = 9.0F;
// Without the barometer for so long, the receiver's height counts.
constexpr float kWithoutBaro = 1.0F;  // s
// Of a receiver's positions and velocities.
constexpr float kLongestFixGap = 1.0F;     // s
constexpr float kComparing = 2.0F;         // s
constexpr float kConsistent = 1.5F;        // m/s
constexpr float kHeadingSuspected = 1.5F;  // s
constexpr float kWitnessAgrees = 0.5F;     // m/s
constexpr float kJumps = 3.0F;             // m, between two fixes
constexpr float kDrifts = 0.9F;            // s
constexpr float kMostOfJump = 1.5F;        // m
constexpr float kWitness = 0.5F;           // s of velocities that were left out
// Parts of an innovation: about 1, 2 and 3 s of fixes, and 1 s of the others.
constexpr float kFollowVelocity = 0.17F;
constexpr float kFollowPosition = 0.1F;
constexpr float kFollowHeight = 0.06F;
constexpr float kFollowBaro = 0.04F;
constexpr float kHeightFits = 12.0F;  // m: five sigmas of a receiver's height
constexpr float kShare = 0.3F;        // of a barometer's jump that the height may have made
// Vertical velocities of satellites and barometer that agree, and what is left to doubt then.
constexpr float kAgrees = 1.5F;            // m/s
constexpr float kDoubtfulVariance = 1.0F;  // m^2/s^2
constexpr float kDoubtfulHeight = 4.0F;    // m^2
// The variance that the heading is given when satellites contradict it for long.
constexpr float kHeadingInflation = 1.0F;  // rad^2
// The field's level part must show a direction.
constexpr float kMinLevelField = 0.02F;  // gauss

ObservationModel observation_of(unsigned state) {
    return {.first = static_cast<ErrorState>(state)};
}

}  // namespace

// At most one scalar fusion, and then at most one step.
void Navigation::work(const NavigationParams& params) {
    const Kinematics before = moved(filter_.kinematics(), window_.ahead());
    const bool fused =
        fuse_gnss(params) || fuse_baro(params) || fuse_mag(params) || fuse_rest(params);
    const bool nothing_left = !fused || (!is_due(gnss_) && !is_due(baro_) && !is_due(mag_));
    if (nothing_left) predict(params, false);
    if (!filter_.is_finite()) {
        started_ = false;
        return;
    }
    if (jumped_)
        output_correction_ = OutputCorrection();
    else
        smooth(before, moved(filter_.kinematics(), window_.ahead()));
    jumped_ = false;
}

// One step of the filter, if the oldest is `fusion_delay` old, or at once.
bool Navigation::predict(const NavigationParams& params, bool at_once) {
    if (window_.empty()) return false;
    const float delay = static_cast<float>(imu_us_ - window_.step_end_us()) * 1e-6F;
    if (!at_once && delay < params.fusion_delay) return false;
    filter_.predict(window_.take(), params, doubt_.force_error());
    return true;
}

// Drops what came too late; true if one is left that the horizon has reached.
template <class Measurement, unsigned kCapacity>
bool Navigation::is_due(DelayedMeasurements<Measurement, kCapacity>& delayed) {
    while (!delayed.empty() && delayed.front().time_us <= filter_.time_us()) {
        if (age(delayed.front().time_us) <= kTooLate) return true;
        delayed.pop();
        ++late_;
        // The next fix begins with its own velocity, however far this one came.
        if constexpr (std::is_same_v<Measurement, GnssMeasurement>) gnss_next_ = 0;
    }
    return false;
}

bool Navigation::fuse_gnss(const NavigationParams& params) {
    if (!is_due(gnss_)) {
        gnss_next_ = 0;
        return false;
    }
    const GnssMeasurement& fix = gnss_.front();
    if (gnss_next_ == 0) compare(fix);
    if (gnss_next_ == 0 && !fix.has_velocity) gnss_next_ = 3;
    if (gnss_next_ < 3)
        fuse_velocity(gnss_next_, fix, params);
    else if (gnss_next_ < 5)
        fuse_position(gnss_next_ - 3, fix, params);
    else if (fix.has_height)
        fuse_height(fix, params);
    if (++gnss_next_ < 6) return true;
    gnss_next_ = 0;
    innovations_.timestamp_sample = fix.time_us;
    measured_ = true;
    gnss_.pop();
    return true;
}

// A receiver's velocity against how its positions change: two measurements that should agree.
void Navigation::compare(const GnssMeasurement& fix) {
    const float dt = static_cast<float>(fix.time_us - last_fix_us_) * 1e-6F;
    fix_interval_s_ = math::clamp(dt, 0.0F, kLongestFixGap);
    const bool is_next = last_fix_us_ != 0 && dt > 0.0F && dt < kLongestFixGap;
    if (is_next && fix.has_velocity) {
        const Vector travelled_N = (fix.velocity_N + last_fix_velocity_N_) * (0.5F * dt);
        Vector jump_N = fix.position_N - last_fix_N_ - travelled_N;
        jump_N.z() += static_cast<float>(last_fix_height_ - fix.height);
        if (!fix.has_height) jump_N.z() = 0.0F;
        inconsistency_N_ += (jump_N - inconsistency_N_ * dt) / (kComparing + dt);
        // One jump says nothing against the velocity; many do.
        const Vector part_N = jump_N.cwiseMin(kMostOfJump).cwiseMax(-kMostOfJump);
        contradiction_N_ += (part_N - contradiction_N_ * dt) / (kComparing + dt);
        const bool drifts = inconsistency_variance(contradiction_N_.head<2>().squaredNorm()) > 0.0F;
        drifts_for_s_ = drifts ? drifts_for_s_ + dt : 0.0F;
        const bool jumps = jump_N.head<2>().squaredNorm() > math::square(kJumps);
        if (jumps || drifts_for_s_ > kDrifts) receiver_jump_N_ += jump_N.head<2>();
    }
    last_fix_N_ = fix.position_N;
    last_fix_height_ = fix.height;
    last_fix_velocity_N_ = fix.velocity_N;
    last_fix_us_ = fix.time_us;
}

bool Navigation::receiver_is_consistent() const {
    return inconsistency_N_.head<2>().squaredNorm() < math::square(kConsistent);
}

// For how long satellites have contradicted the estimate, with short breaks.
float Navigation::contradicts_for(uint64_t time_us) {
    constexpr uint64_t kBreak_us = 2'000'000;
    if (contradicted_us_ == 0 || time_us - contradicted_us_ > kBreak_us) contradicts_us_ = time_us;
    contradicted_us_ = time_us;
    return static_cast<float>(time_us - contradicts_us_) * 1e-6F;
}

void Navigation::fuse_velocity(unsigned axis, const GnssMeasurement& fix,
                               const NavigationParams& params) {
    const Vector expected =
        filter_.kinematics().velocity_N - filter_.acceleration_N() * age(fix.time_us);
    const Vector difference = fix.velocity_N - expected;
    const float innovation = difference(axis);
    const float contradiction =
        axis == 2 ? math::square(contradiction_N_.z()) : contradiction_N_.head<2>().squaredNorm();
    const float variance = fix.velocity_variance + inconsistency_variance(contradiction);
    const Fusion done =
        filter_.fuse(observation_of(kVelocity + axis), innovation, variance, params.gate);
    Disagreement::follow(disagreement_.velocity_N(axis), innovation, kFollowVelocity);
    ratios_.vel_test_ratio =
        axis == 0 ? done.test_ratio : math::max(ratios_.vel_test_ratio, done.test_ratio);
    if (axis == 2) {
        innovations_.gps_vvel = innovation;
        doubt_.correct(innovation, fix_interval_s_);
        vertical_refused_s_ = done.fused() ? 0.0F : vertical_refused_s_ + fix_interval_s_;
        if (!done.fused()) believe_vertical(fix, fix.velocity_N.z());
        return;
    }
    innovations_.gps_hvel[axis] = innovation;
    if (axis == 0) {
        north_fused_ = done.fused();
        return;
    }
    const bool first = !velocity_aid_.started();
    const bool fused = !first && north_fused_ && done.fused();
    const bool late = velocity_aid_.note(fused, fix.time_us, params.reset_timeout);
    if (flies_ && velocity_aid_.refused_for(fix.time_us) > kWitness) astray_us_ = imu_us_;
    // Positions that move as the velocity says are a second witness against the inertial solution.
    const bool agreed = velocity_aid_.refused_for(fix.time_us) > kWitness &&
                        inconsistency_N_.head<2>().squaredNorm() < math::square(kWitnessAgrees) &&
                        proven_s_ >= kProven_s;
    if (!late && !agreed && !first) return;
    if (late && !first && !receiver_is_consistent()) return;  // it contradicts itself
    // Otherwise the heading is what made them differ, or the inertial sensors.
    // A glitch of these is over soon; a wrong heading contradicts again and again.
    if (!first && (contradicts_for(fix.time_us) > kHeadingSuspected || late))
        filter_.inflate_heading_variance(kHeadingInflation);
    else if (!first)
        filter_.forget_inertial_errors();
    filter_.set_horizontal_velocity(fix.velocity_N.head<2>(), fix.velocity_variance);
    velocity_aid_.accept(fix.time_us);
    resets_.delta_vxy = {difference.x(), difference.y()};
    ++resets_.vxy_reset_counter;
    jumped_ = true;
}

// Satellites contradict the vertical velocity. If the barometer agrees with them, the inertial
// solution is what is wrong: two sensors that know nothing of each other are believed at once.
// Without a barometer that agrees with either, their heights are the witness, a little later.
void Navigation::believe_vertical(const GnssMeasurement& fix, float velocity) {
    if (!velocity_aid_.started() || !baro_rate_.known(fix.time_us)) return;
    const float sinks = -baro_rate_.value();
    const bool is_alone = vertical_refused_s_ > kWitness && fix.has_height &&
                          math::abs(inconsistency_N_.z()) < kWitnessAgrees &&
                          math::abs(sinks - filter_.kinematics().velocity_N.z()) > kAgrees;
    if (math::abs(sinks - velocity) > kAgrees && !is_alone) return;
    doubt_.agreed();
    const float now = velocity + filter_.acceleration_N().z() * age(fix.time_us);
    filter_.set_vertical_velocity(now, kDoubtfulVariance);
    // The barometer decides where that was.
    filter_.set_down(filter_.kinematics().position_N.z(), kDoubtfulHeight);
    jumped_ = true;
}

void Navigation::fuse_position(unsigned axis, const GnssMeasurement& fix,
                               const NavigationParams& params) {
    const Vector expected =
        filter_.kinematics().position_N - filter_.kinematics().velocity_N * age(fix.time_us);
    const Vector difference = fix.position_N - expected;
    const float innovation = difference(axis);
    const Fusion done = filter_.fuse(observation_of(kPosition + axis), innovation,
                                     fix.position_variance, params.gate);
    innovations_.gps_hpos[axis] = innovation;
    // A jump of the position alone is the receiver's.
    const bool counts = done.fused() || velocity_aid_.refused_for(fix.time_us) > 0.0F;
    if (counts) Disagreement::follow(disagreement_.position_N(axis), innovation, kFollowPosition);
    ratios_.pos_test_ratio =
        axis == 0 ? done.test_ratio : math::max(ratios_.pos_test_ratio, done.test_ratio);
    if (axis == 0) {
        north_fused_ = done.fused();
        return;
    }
    const bool first = !position_aid_.started();
    const bool fused = !first && north_fused_ && done.fused();
    // What is fused takes the estimate to where the receiver went.
    if (fused) disagreement_.follow_jump(receiver_jump_N_, kFollowPosition);
    if (!position_aid_.note(fused, fix.time_us, params.reset_timeout) && !first) return;
    if (!first) disagreement_.jump_N.head<2>() += difference.head<2>();
    const Vector now = fix.position_N + filter_.kinematics().velocity_N * age(fix.time_us);
    filter_.set_horizontal_position(now.head<2>(), fix.position_variance);
    position_aid_.accept(fix.time_us);
    resets_.delta_xy = {difference.x(), difference.y()};
    ++resets_.xy_reset_counter;
    jumped_ = true;
}

void Navigation::fuse_height(const GnssMeasurement& fix, const NavigationParams& params) {
    const Kinematics& at = filter_.kinematics();
    const float down = at.position_N.z() - at.velocity_N.z() * age(fix.time_us);
    if (!has_origin_height_) origin_height_ = fix.height + static_cast<double>(down);
    has_origin_height_ = true;
    const float innovation = static_cast<float>(origin_height_ - fix.height) - down;
    const Fusion done =
        filter_.fuse(observation_of(kPosition + 2), innovation, fix.height_variance, params.gate);
    innovations_.gps_vpos = innovation;
    Disagreement::follow(disagreement_.position_N.z(), innovation, kFollowHeight);
    gnss_height_fits_ = math::abs(innovation) < kHeightFits;
    if (!baro_has_failed_ && barometer_drifts()) {
        // Satellites' height and velocity are two against one.
        baro_has_failed_ = true;
        filter_.set_down(
            static_cast<float>(origin_height_ - fix.height) + at.velocity_N.z() * age(fix.time_us),
            fix.height_variance);
        disagreement_.position_N.z() = disagreement_.baro = 0.0F;
        height_aid_.accept(fix.time_us);
        jumped_ = true;
        return;
    }
    if (done.fused() && !height_aid_.recent(fix.time_us, kWithoutBaro))
        height_aid_.accept(fix.time_us);
}

// Satellites see it rise or sink away from where the barometer holds it, and their velocity, too.
bool Navigation::barometer_drifts() const {
    constexpr float kHeight = 6.0F;    // m
    constexpr float kVelocity = 0.2F;  // m/s
    const float height = disagreement_.position_N.z();
    const float velocity = disagreement_.velocity_N.z();
    return flies_ && math::abs(inconsistency_N_.z()) < kWitnessAgrees &&
           math::abs(height) > kHeight && math::abs(velocity) > kVelocity &&
           height * velocity > 0.0F;
}

bool Navigation::fuse_baro(const NavigationParams& params) {
    if (!is_due(baro_)) return false;
    const BaroMeasurement sample = baro_.front();
    baro_.pop();
    if (baro_has_failed_) return true;
    const Kinematics& at = filter_.kinematics();
    const float height =
        -(at.position_N.z() - at.velocity_N.z() * age(sample.time_us)) + filter_.baro_offset();
    baro_rate_.add(sample.time_us, sample.height);
    if (baro_rate_.known(sample.time_us))
        Disagreement::follow(disagreement_.baro_velocity, -baro_rate_.value() - at.velocity_N.z(),
                             kFollowBaro);
    if (!has_baro_reference_) baro_reference_ = sample.height - height;
    has_baro_reference_ = true;
    const float innovation = sample.height - baro_reference_ - height;
    const ObservationModel model{static_cast<ErrorState>(kPosition + 2), -1.0F, kBaroOffset, 1.0F};
    const Fusion done =
        filter_.fuse(model, innovation, math::square(params.baro_noise), params.gate);
    innovations_.baro_vpos = innovation;
    Disagreement::follow(disagreement_.baro, innovation, kFollowBaro);
    innovations_.timestamp_sample = sample.time_us;
    ratios_.hgt_test_ratio = done.test_ratio;
    measured_ = true;
    if (!height_aid_.note(done.fused(), sample.time_us, params.reset_timeout)) return true;
    disagreement_.baro = 0.0F;
    if (height_aid_.started() && gnss_height_fits_) {
        // The barometer jumped, not the vehicle: satellites say so, too.
        baro_reference_ += innovation;
        disagreement_.jump_N.z() += kShare * innovation;
        height_aid_.accept(sample.time_us);
        return true;
    }
    if (height_aid_.started()) disagreement_.jump_N.z() -= innovation;
    filter_.set_down(at.position_N.z() - innovation, math::square(params.baro_noise));
    filter_.set_vertical_velocity(at.velocity_N.z(), kFlightVariance);
    height_aid_.accept(sample.time_us);
    resets_.delta_z = -innovation;
    ++resets_.z_reset_counter;
    jumped_ = true;
    return true;
}

// The direction of the field, turned level with the estimated tilt, against magnetic north.
bool Navigation::fuse_mag(const NavigationParams& params) {
    if (!is_due(mag_)) return false;
    const MagMeasurement sample = mag_.front();
    mag_.pop();
    const Vector field_N = filter_.kinematics().q_NB * sample.field_B;
    if (!(field_N.head<2>().squaredNorm() > math::square(kMinLevelField))) return true;
    // A wrong tilt turns the level part of a field that dips.
    const float dip = math::square(field_N.z()) / field_N.head<2>().squaredNorm();
    const float tilt_variance = 0.5F * (filter_.variance(kTurn) + filter_.variance(kTurn + 1));
    const float variance = math::square(params.mag_noise) + dip * tilt_variance;
    const float turned = filter_.heading_rate() * age(sample.time_us);
    const float seen = math::atan2(field_N.y(), field_N.x()) - turned;
    const float innovation =
        math::wrap_pi(params.magnetic_declination - seen - filter_.mag_offset());
    if (!heading_aid_.started()) {
        align_heading(innovation, variance, params);
        heading_aid_.accept(sample.time_us);
        return true;
    }
    const ObservationModel model{kHeading, 1.0F, kMagOffset, 1.0F};
    const Fusion done = filter_.fuse(model, innovation, variance, params.gate, true);
    innovations_.heading = innovation;
    Disagreement::follow(disagreement_.heading, innovation, kFollowBaro);
    innovations_.timestamp_sample = sample.time_us;
    ratios_.mag_test_ratio = done.test_ratio;
    measured_ = true;
    if (heading_aid_.note(done.fused(), sample.time_us, params.reset_timeout)) {
        // Something magnetic came or went; the gyro knows better.
        disagreement_.heading_jump = math::wrap_pi(disagreement_.heading_jump + innovation);
        disagreement_.heading = 0.0F;
        filter_.shift_mag_offset(innovation, math::square(params.mag_offset_uncertainty));
        heading_aid_.accept(sample.time_us);
    }
    return true;
}

void Navigation::align_heading(float error, float variance, const NavigationParams& params) {
    filter_.align_heading(error, variance, math::square(params.mag_offset_uncertainty));
    resets_.delta_heading = error;
    ++resets_.heading_reset_counter;
    jumped_ = true;
}

// One axis of a velocity of zero.
bool Navigation::fuse_rest(const NavigationParams& params) {
    if (filter_.time_us() < rest_due_us_) return false;
    const unsigned axis = rest_next_;
    rest_next_ = (axis + 1) % 3;
    if (rest_next_ == 0) rest_due_us_ = filter_.time_us() + kRestInterval_us;
    const bool still = rest_s_ >= kRestTime;
    const Aid& aid = axis < 2 ? velocity_aid_ : height_aid_;
    if (!still && aid.recent(filter_.time_us(), params.dead_reckoning_timeout)) return false;
    const float velocity = filter_.kinematics().velocity_N(axis);
    filter_.fuse(observation_of(kVelocity + axis), -velocity,
                 still ? kRestVariance : kFlightVariance, 1e3F);
    return true;
}

}  // namespace stator::apps::navigation
