// Flight on three of four rotors.
#include "three_rotors.hpp"

namespace stator::apps::motor_loss {

namespace {

constexpr float kOpposite = 0.6F;      // its thrust, of that of a rotor beside the lost one
constexpr float kMostLean = 0.15F;     // rad, of the axis in B
constexpr float kSlowest = 2.0F;       // rad/s, a slower spin has no such axis
constexpr float kMostTurning = 40.0F;  // rad/s^2
constexpr float kIdle = 0.02F;

Vector2 limited(const Vector2& v, float most) {
    const float length = math::norm(v);
    return length > most ? Vector2(v * (most / length)) : v;
}

}  // namespace

void ThreeRotors::configure(const Quad& quad, unsigned lost) {
    lost_ = lost;
    // The rotor whose place is most nearly across the centre.
    float least = 0.0F;
    for (unsigned i = 0; i < kRotors; ++i) {
        const float along = quad.place_B[i].dot(quad.place_B[lost]);
        if (i == lost || along >= least) continue;
        least = along;
        opposite_ = i;
    }
    side_ = kRotors;
    for (unsigned i = 0; i < kRotors; ++i) {
        if (i == lost || i == opposite_) continue;
        (side_ == kRotors ? side_ : other_side_) = i;
    }
}

// m_x and m_y, for rotors that carry `sum` in the usual shares.
Vector2 ThreeRotors::axis(const Quad& quad, float spin, float sum, float force_per_command) const {
    if (math::abs(spin) < kSlowest) return Vector2::Zero();
    const float side = sum / (2.0F + kOpposite);
    const Vector2 torque = (quad.arm(opposite_) * (kOpposite * side) +
                            (quad.arm(side_) + quad.arm(other_side_)) * side) *
                           force_per_command;
    const Vector2 unit = quad.gyroscopic({1.0F, 1.0F, 1.0F}) * math::square(spin);
    return limited({torque.y() / unit.y(), torque.x() / unit.x()}, kMostLean);
}

Commands ThreeRotors::update(const Quad& quad, const Gains& gains, const Vector3& down_B,
                             const Vector3& rate_B, float thrust, float force_per_command) const {
    const float sum = static_cast<float>(kRotors) * thrust;
    const float spin = rate_B.z();
    const Vector2 lean = axis(quad, spin, sum, force_per_command);
    const Vector3 axis_B = math::normalized(Vector3(lean.x(), lean.y(), 1.0F));
    Vector3 error = axis_B.cross(down_B);
    if (axis_B.dot(down_B) < 0.0F) error = math::normalized(error, Vector3(Vector3::UnitX()));
    const Vector2 turn = gains.tilt_p * error.head<2>();
    const Vector2 wanted = spin * lean + turn;
    // What is constant in N turns the other way in B.
    const Vector2 turning(spin * turn.y(), -spin * turn.x());
    const Vector2 acceleration =
        limited(gains.rate_p * (wanted - rate_B.head<2>()) + turning, kMostTurning);
    // And where it will be once the rotors have followed.
    const auto ahead = math::sincos(-spin * gains.rotor_lag);
    const Vector2 led(ahead.cos * acceleration.x() - ahead.sin * acceleration.y(),
                      ahead.sin * acceleration.x() + ahead.cos * acceleration.y());
    const Vector2 torque = quad.gyration2.head<2>().cwiseProduct(led) + quad.gyroscopic(rate_B);
    return allocate(quad, torque / force_per_command, sum);
}

// Torque first, then the sum. In units of a rotor's most thrust, times metres.
Commands ThreeRotors::allocate(const Quad& quad, const Vector2& torque, float sum) const {
    const Vector2 a = quad.arm(side_);
    const Vector2 b = quad.arm(other_side_);
    const Vector2 o = quad.arm(opposite_);
    const Vector2 middle = 0.5F * (a + b);
    const Vector2 between = a - b;
    // torque = opposite (o - middle) + sum middle + difference between, solved for both.
    const Vector2 left = torque - sum * middle;
    const Vector2 first = o - middle;
    const float area = first.x() * between.y() - first.y() * between.x();
    const float exact = (left.x() * between.y() - left.y() * between.x()) / area;
    const float opposite = math::clamp(exact, kIdle, 1.0F);
    const Vector2 rest = left - opposite * first;
    const float most = 0.5F * (1.0F - kIdle);
    const float difference = math::clamp(rest.dot(between) / between.squaredNorm(), -most, most);
    const float room = math::abs(difference);
    const float half = math::clamp(0.5F * (sum - opposite), kIdle + room, 1.0F - room);
    Commands commands;
    commands[lost_] = math::canonical_nan<float>();
    commands[opposite_] = opposite;
    commands[side_] = half + difference;
    commands[other_side_] = half - difference;
    return commands;
}

}  // namespace stator::apps::motor_loss
