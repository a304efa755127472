// Recognises magnetic disturbances by strength and dip. The rules and times are those of VQF.
#include "magnetic_field.hpp"

namespace stator::apps::attitude {

namespace {

constexpr float kSmoothing = 0.05F;          // s
constexpr float kUsualTimeConstant = 20.0F;  // s
constexpr float kMinUndisturbed = 0.5F;      // s
constexpr float kFirstCandidate = 5.0F;      // s of motion before a first field is believed
constexpr float kNewCandidate = 20.0F;       // and another one
constexpr float kDistrust = 0.5F;            // of a field that stayed disturbed for too long
constexpr float kRecovery = 2.0F;  // how much faster rejected time is forgotten than it gathers

// True if two fields agree in strength and dip.
bool agree(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const AttitudeParams& params) {
    const float strength_a = math::norm(a);
    const float strength_b = math::norm(b);
    const float difference = math::abs(strength_a - strength_b);
    if (!(difference < params.mag_strength_tolerance * strength_b)) return false;
    // The tolerance is small, so that its sine is as good as itself.
    const float cross = math::abs(a.x() * b.y() - a.y() * b.x());
    return a.dot(b) > 0.0F && cross < params.mag_dip_tolerance * strength_a * strength_b;
}

}  // namespace

float MagneticField::trust(const math::Vector3<float>& field_T, bool moving, float dt,
                           const AttitudeParams& params) {
    const Strength sample(math::norm(field_T.head<2>()), field_T.z());
    now_ += (sample - now_) * smoothing_.next(dt, kSmoothing);
    const bool usual = agree(now_, usual_, params);
    undisturbed_s_ = usual ? undisturbed_s_ + dt : 0.0F;
    if (undisturbed_s_ >= kMinUndisturbed) {
        usual_ += (now_ - usual_) * (dt / (kUsualTimeConstant + dt));
        candidate_s_ = 0.0F;
        rejected_s_ = math::max(rejected_s_ - kRecovery * dt, 0.0F);
        return 1.0F;
    }
    look_for_another(moving, dt, params);
    const bool first = usual_.isZero(0.0F);
    if (first || rejected_s_ >= params.mag_longest_rejection) return kDistrust;
    rejected_s_ += dt;
    return 0.0F;
}

void MagneticField::look_for_another(bool moving, float dt, const AttitudeParams& params) {
    if (!agree(now_, candidate_, params)) {
        candidate_ = now_;
        candidate_s_ = 0.0F;
        return;
    }
    candidate_ += (now_ - candidate_) * (dt / (kUsualTimeConstant + dt));
    if (moving) candidate_s_ += dt;
    const float enough = usual_.isZero(0.0F) ? kFirstCandidate : kNewCandidate;
    if (candidate_s_ >= enough) usual_ = candidate_;
}

}  // namespace stator::apps::attitude
