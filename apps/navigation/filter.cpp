// The error-state Kalman filter.
#include "filter.hpp"

namespace stator::apps::navigation {

namespace {

constexpr float kLargestAccelBias = 1.5F;  // m/s^2
constexpr float kLargestGyroBias = 0.2F;   // rad/s
constexpr float kNearly = 0.95F;           // of these

// A step longer than this spans a gap between samples, in which the vehicle moved unseen:
// it turned and accelerated otherwise by about this much.
constexpr float kGap = 0.1F;       // s
constexpr float kGapRate = 0.1F;   // rad/s
constexpr float kGapForce = 1.0F;  // m/s^2

// For how long what stands in for an accelerometer in doubt is wrong the same way.
constexpr float kDoubtTime = 0.2F;  // s
// What was learned meanwhile may be wrong by this.
constexpr float kDoubtfulGyroBias = 0.03F;  // rad/s

// Below, the force along the ground is noise and the tilt's error, and says nothing of the heading:
// taken for true it would make the filter sure of a heading that was never measured.
constexpr float kTellingForce = 0.5F;  // m/s^2
constexpr float kTellingTime = 1.0F;   // s

Vector clamped(const Vector& v, float most) {
    return v.cwiseMin(most).cwiseMax(-most);
}

Covariance::Noise noise_of(float time, const NavigationParams& params) {
    Covariance::Noise noise{.turn = math::square(params.gyro_noise) * time,
                            .velocity = math::square(params.accel_noise) * time,
                            .gyro_bias = math::square(params.gyro_bias_walk) * time,
                            .accel_bias = math::square(params.accel_bias_walk) * time,
                            .baro_offset = math::square(params.baro_drift) * time,
                            .mag_offset = math::square(params.mag_offset_walk) * time};
    if (time > kGap) {
        noise.turn += math::square(kGapRate * time);
        noise.velocity += math::square(kGapForce * time);
    }
    return noise;
}

// What an unknown heading hides from the first order: a push seen under an error psi is wrong by
// psi^2 / 2 of it along itself, E psi^4 = 3 sigma^4. That error lasts, so that it adds up over the
// steps between two fixes. Without it the filter is sure of a heading long before it is right.
float second_order(const Vector& push_N, float time, float heading_variance) {
    constexpr float kBetweenFixes = 0.2F;  // s
    return push_N.head<2>().squaredNorm() * 0.75F * math::square(heading_variance) *
           (kBetweenFixes / time);
}

}  // namespace

Kinematics moved(const Kinematics& start, const Motion& motion) {
    const math::Matrix3<float> R_NB = start.q_NB.toRotationMatrix();
    const float t = motion.time;
    const Vector g(0.0F, 0.0F, kGravity);
    return {.q_NB = math::normalized(start.q_NB * motion.turn),
            .velocity_N = start.velocity_N + g * t + R_NB * motion.velocity,
            .position_N = start.position_N + start.velocity_N * t + g * (0.5F * t * t) +
                          R_NB * motion.position};
}

bool Filter::is_finite() const {
    const float sum = kinematics_.q_NB.squaredNorm() + kinematics_.velocity_N.squaredNorm() +
                      kinematics_.position_N.squaredNorm() + bias_.gyro.squaredNorm() +
                      bias_.accel.squaredNorm() + baro_offset_ + mag_offset_;
    return math::is_finite(sum);
}

bool Filter::has_impossible_accel_bias() const {
    return bias_.accel.cwiseAbs().maxCoeff() > kNearly * kLargestAccelBias;
}

bool Filter::has_impossible_bias() const {
    return has_impossible_accel_bias() ||
           bias_.gyro.cwiseAbs().maxCoeff() > kNearly * kLargestGyroBias;
}

void Filter::start(uint64_t time_us, const Quaternion& q_NB, float tilt_variance,
                   float heading_variance, const NavigationParams& params) {
    *this = Filter();
    time_us_ = time_us;
    kinematics_.q_NB = q_NB;
    covariance_.reset(kHeading, 1, heading_variance);
    covariance_.reset(kVelocity, 3, 0.25F);
    covariance_.reset(kPosition, 3, 0.01F);
    covariance_.reset(kGyroBias, 3, math::square(params.gyro_bias_uncertainty));
    covariance_.level(q_NB.toRotationMatrix(), kGravity,
                      math::square(params.accel_bias_uncertainty), tilt_variance);
    covariance_.reset(kBaroOffset, 1, 0.01F);
    covariance_.reset(kMagOffset, 1, math::square(params.mag_offset_uncertainty));
    covariance_.limit();
}

void Filter::predict(const MotionWindow::Step& step, const NavigationParams& params,
                     float force_error) {
    Motion motion = step.motion;
    const float time = motion.time;
    // What the bias changed by since it was taken off.
    motion.turn = motion.turn * math::from_rotation_vector((step.bias.gyro - bias_.gyro) * time);
    motion.velocity += (step.bias.accel - bias_.accel) * time;
    const math::Matrix3<float> R_NB = kinematics_.q_NB.toRotationMatrix();
    const Vector push_N = R_NB * motion.velocity;
    const Vector turn_N = R_NB * Vector(motion.turn.vec() * 2.0F);
    Vector seen_push_N = push_N;
    level_force_N_ += (push_N.head<2>() - level_force_N_ * time) / (kTellingTime + time);
    if (level_force_N_.squaredNorm() < math::square(kTellingForce)) seen_push_N.head<2>().setZero();
    Covariance::Noise noise = noise_of(time, params);
    noise.velocity += second_order(seen_push_N, time, variance(kHeading));
    noise.velocity += math::square(force_error) * kDoubtTime * time;
    // Nothing is learned of an accelerometer that is not used.
    if (force_error > 0.0F)
        covariance_.reset(ErrorState::kAccelBias, 3, math::square(params.accel_bias_uncertainty));
    covariance_.predict(R_NB, seen_push_N, time, noise);
    covariance_.limit();
    kinematics_ = moved(kinematics_, motion);
    time_us_ = step.end_us;
    acceleration_N_ = push_N / time + Vector(0.0F, 0.0F, kGravity);
    heading_rate_ = turn_N.z() / time;
}

Fusion Filter::fuse(const ObservationModel& model, float innovation, float variance, float gate,
                    bool keep_tilt) {
    const Covariance::Column cross = covariance_.cross_covariance(model);
    const float innovation_variance =
        model.first_sign * cross[model.first] + model.second_sign * cross[model.second] + variance;
    const Fusion result{
        .innovation = innovation,
        .test_ratio = math::square(innovation) / (math::square(gate) * innovation_variance)};
    if (!result.fused()) return result;
    Covariance::Column error;
    const float scale = innovation / innovation_variance;
    for (unsigned i = 0; i < kStates; ++i) error[i] = cross[i] * scale;
    covariance_.correct(cross, innovation_variance, keep_tilt);
    inject(error, keep_tilt);
    return result;
}

void Filter::inject(const Covariance::Column& error, bool keep_tilt) {
    const auto part = [&error](unsigned first) {
        return Vector(error[first], error[first + 1], error[first + 2]);
    };
    Vector turn_N = part(kTurn);
    if (keep_tilt) turn_N.head<2>().setZero();
    kinematics_.q_NB = math::normalized(math::from_rotation_vector(turn_N) * kinematics_.q_NB);
    kinematics_.velocity_N += part(kVelocity);
    kinematics_.position_N += part(kPosition);
    bias_.gyro = clamped(bias_.gyro + part(kGyroBias), kLargestGyroBias);
    bias_.accel = clamped(bias_.accel + part(kAccelBias), kLargestAccelBias);
    baro_offset_ += error[kBaroOffset];
    mag_offset_ = math::wrap_pi(mag_offset_ + error[kMagOffset]);
}

void Filter::set_horizontal_velocity(const Eigen::Vector2f& velocity, float variance) {
    kinematics_.velocity_N.head<2>() = velocity;
    covariance_.reset(kVelocity, 2, variance);
}

void Filter::set_vertical_velocity(float velocity, float variance) {
    kinematics_.velocity_N.z() = velocity;
    covariance_.reset(kVelocity + 2, 1, variance);
}

void Filter::set_horizontal_position(const Eigen::Vector2f& position, float variance) {
    kinematics_.position_N.head<2>() = position;
    covariance_.reset(kPosition, 2, variance);
}

void Filter::set_down(float down, float variance) {
    kinematics_.position_N.z() = down;
    covariance_.reset(kPosition + 2, 1, variance);
}

void Filter::align_heading(float error, float noise_variance, float offset_variance) {
    const Vector down(0.0F, 0.0F, 1.0F);
    kinematics_.q_NB = math::normalized(math::from_axis_angle(down, error) * kinematics_.q_NB);
    mag_offset_ = 0.0F;
    covariance_.reset(kHeading, 1, noise_variance);
    covariance_.reset(kMagOffset, 1, 0.0F);
    covariance_.loosen(kHeading, kMagOffset, offset_variance);
    covariance_.limit();
}

void Filter::forget_inertial_errors() {
    constexpr float kTilt = 0.05F;      // rad
    constexpr float kAccelBias = 0.5F;  // m/s^2
    covariance_.reset(kTurn, 2, math::square(kTilt));
    covariance_.reset(ErrorState::kGyroBias, 3, math::square(kDoubtfulGyroBias));
    covariance_.reset(ErrorState::kAccelBias, 3, math::square(kAccelBias));
}

void Filter::forget_accel_bias() {
    constexpr float kTilt = 0.2F;            // rad
    constexpr float kAccelBias = 0.5F;       // m/s^2
    constexpr float kUnknownHeading = 1.0F;  // rad^2
    bias_.accel.setZero();
    for (unsigned turn = kTurn; turn < kTurn + 2; ++turn)
        covariance_.reset(turn, 1, math::max(variance(turn), math::square(kTilt)));
    covariance_.reset(ErrorState::kAccelBias, 3, math::square(kAccelBias));
    covariance_.reset(ErrorState::kGyroBias, 3, math::square(kDoubtfulGyroBias));
    inflate_heading_variance(kUnknownHeading);
}

void Filter::shift_mag_offset(float change, float variance) {
    mag_offset_ = math::wrap_pi(mag_offset_ + change);
    covariance_.reset(kMagOffset, 1, variance);
    covariance_.limit();
}

}  // namespace stator::apps::navigation
