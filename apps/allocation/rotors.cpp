// Control allocation: pseudo-inverse and desaturation in order of priority.
#include "rotors.hpp"

namespace stator::apps::allocation {

using math::Vector3;

namespace {

using Vector4 = Eigen::Matrix<float, 4, 1>;
using Matrix4 = Eigen::Matrix<float, 4, 4>;

// det(G) over the product of G's diagonal is 1 for rows at right angles and 0 for dependent ones.
constexpr float kMinIndependence = 1e-3F;
// Below this, a rotor does not help to lift.
constexpr float kMinLift = 1e-3F;

// Roll, pitch, yaw torque and lift of a unit of thrust: position x thrust, and the drag's moment.
Vector4 effectiveness(const Rotor& rotor) {
    return {-rotor.y, rotor.x, rotor.moment, 1.0F};
}

// What the rotors make at most: torque with those of one sign at full thrust and the others
// stopped, lift with all at full thrust.
Vector4 most_of_each(std::span<const Rotor> rotors) {
    Vector4 sum = Vector4::Zero();
    for (const Rotor& rotor : rotors) sum += effectiveness(rotor).cwiseAbs();
    return sum.cwiseProduct(Vector4(0.5F, 0.5F, 0.5F, 1.0F));
}

}  // namespace

bool Rotors::set_geometry(std::span<const Rotor> rotors) {
    if (rotors.size() > kMaxRotors) return false;
    count_ = static_cast<unsigned>(rotors.size());
    const Vector4 most = most_of_each(rotors);
    if (!(most.minCoeff() > 0.0F)) return false;

    Matrix4 gram = Matrix4::Zero();  // B * B^T
    for (const Rotor& rotor : rotors) {
        const Vector4 column = effectiveness(rotor).cwiseQuotient(most);
        gram += column * column.transpose();
    }
    const float independence = gram.determinant() / gram.diagonal().prod();
    if (!(independence > kMinIndependence)) return false;

    const Matrix4 inverse = gram.inverse();
    for (unsigned i = 0; i < count_; ++i) {
        const Vector4 row = inverse * effectiveness(rotors[i]).cwiseQuotient(most);
        if (!(row[3] > kMinLift)) return false;
        share_[i] = {row[0] / row[3], row[1] / row[3], row[2] / row[3], row[3]};
    }
    find_range();
    return true;
}

void Rotors::set_range(float idle, bool airmode) {
    idle_ = idle;
    airmode_ = airmode;
    find_range();
}

void Rotors::find_range() {
    if (count_ == 0) return;
    float least_lift = share_[0].lift;
    float most_lift = share_[0].lift;
    for (unsigned i = 1; i < count_; ++i) {
        least_lift = math::min(least_lift, share_[i].lift);
        most_lift = math::max(most_lift, share_[i].lift);
    }
    lowest_ = idle_ / least_lift;
    highest_ = 1.0F / most_lift;
}

// The thrust nearest to the wanted one at which roll and pitch, which reach from `least` (<= 0) to
// `most` (>= 0), fit; without airmode they must do with what the wanted thrust leaves below it.
float Rotors::thrust_for(float thrust, float least, float most) const {
    const float floor = airmode_ ? lowest_ - least : lowest_;
    return math::min(math::max(thrust, floor), highest_ - most);
}

// The largest part of the wanted yaw, in [0, 1], that keeps every rotor in range.
float Rotors::yaw_share(std::span<const float> level, float yaw) const {
    float part = 1.0F;
    for (unsigned i = 0; i < count_; ++i) {
        const float added = share_[i].yaw * yaw;
        const float end = added > 0.0F ? highest_ : lowest_;
        const float room = end - level[i];
        if (math::abs(added) > math::abs(room)) part = math::min(part, room / added);
    }
    return math::max(part, 0.0F);
}

void Rotors::allocate(const Vector3<float>& torque, float thrust, std::span<float> control) const {
    std::array<float, kMaxRotors> level;
    float least = 0.0F;
    float most = 0.0F;
    for (unsigned i = 0; i < count_; ++i) {
        level[i] = share_[i].roll * torque.x() + share_[i].pitch * torque.y();
        least = math::min(least, level[i]);
        most = math::max(most, level[i]);
    }
    // Roll and pitch shrink together, so that the axis of the torque stays.
    const float range = highest_ - lowest_;
    float part = most - least > range ? range / (most - least) : 1.0F;
    const float lift = thrust_for(thrust, part * least, part * most);
    const float room_below = math::max(lift - lowest_, 0.0F);
    if (-least * part > room_below) part = room_below / -least;
    for (unsigned i = 0; i < count_; ++i) level[i] = lift + part * level[i];

    const float yaw = torque.z() * yaw_share(std::span(level).first(count_), torque.z());
    for (unsigned i = 0; i < count_; ++i) {
        const Share& share = share_[i];
        // Rounding may leave the range by a few units in the last place.
        control[i] = math::clamp(share.lift * (level[i] + share.yaw * yaw), idle_, 1.0F);
    }
}

}  // namespace stator::apps::allocation
