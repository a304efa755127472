// The ground under the vehicle.
#include "world/ground.hpp"

namespace stator::world {

namespace {

double farthest(const std::vector<Vector3>& points) {
    double squared = 0.0;
    for (const Vector3& point : points) squared = math::max(squared, point.squaredNorm());
    return math::sqrt(squared);
}

// v, shortened to `most` if it is longer.
Vector3 limited(const Vector3& v, double most) {
    const double squared = v.squaredNorm();
    if (squared <= most * most) return v;
    return v * (most / math::sqrt(squared));
}

}  // namespace

Rest rest_of(const GroundParameters& parameters, double weight) {
    struct Spring {
        Vector3 place_B;
        double stiffness;
    };
    std::vector<Spring> springs;
    for (unsigned i = 0; i < parameters.feet; ++i) {
        springs.push_back({parameters.points_B[i], parameters.stiffness});
    }
    for (const Wheel& wheel : parameters.wheels) {
        springs.push_back({wheel.place_B, wheel.stiffness});
    }
    // Newton's method on height and pitch; the springs pull as well as they push.
    constexpr unsigned kSteps = 30;
    constexpr double kMostPitch = 0.5;
    Rest rest;
    double height = 0.0;  // of the centre of mass below the springs' ends, mean
    for (const Spring& spring : springs) height += spring.place_B.z();
    height /= static_cast<double>(springs.size());
    for (unsigned step = 0; step < kSteps; ++step) {
        const auto [sin, cos] = math::sincos(rest.pitch);
        double force = -weight;
        double torque = 0.0;  // nose down
        double f_h = 0.0;
        double f_p = 0.0;
        double t_p = 0.0;
        for (const Spring& spring : springs) {
            const double ahead = cos * spring.place_B.x() + sin * spring.place_B.z();
            const double below = cos * spring.place_B.z() - sin * spring.place_B.x();
            const double push = spring.stiffness * (below - height);
            force += push;
            torque -= push * ahead;
            f_h -= spring.stiffness;
            f_p -= spring.stiffness * ahead;
            t_p += spring.stiffness * ahead * ahead - push * below;
        }
        // d torque / d height = -f_p, as the springs are one potential.
        const double determinant = f_h * t_p + f_p * f_p;
        if (determinant == 0.0) break;
        height -= (force * t_p - torque * f_p) / determinant;
        rest.pitch -= (f_h * torque + f_p * force) / determinant;
        rest.pitch = math::clamp(rest.pitch, -kMostPitch, kMostPitch);
    }
    rest.surface_z = height;
    return rest;
}

Ground::Ground(const GroundParameters& parameters, double surface_z)
    : parameters_(parameters), surface_z_(surface_z), reach_(farthest(parameters.points_B)) {
    for (const Wheel& wheel : parameters.wheels) {
        reach_ = math::max(reach_, math::norm(wheel.place_B));
    }
    anchors_N_.fill(Vector3::Zero());
    rolls_B_.fill(Vector3::UnitX());
}

void Ground::steer(unsigned wheel, double angle) {
    const auto [sin, cos] = math::sincos(angle);
    rolls_B_[wheel] = Vector3(cos, sin, 0.0);
}

bool Ground::is_near(const Motion& motion) const {
    return motion.position_N.z() + reach_ > surface_z_;
}

Ground::Contact Ground::contact(unsigned point, const Motion& motion) const {
    const auto points = static_cast<unsigned>(parameters_.points_B.size());
    Contact result;
    result.stiffness = parameters_.stiffness;
    result.damping = parameters_.damping;
    if (point < points) {
        result.arm_B = parameters_.points_B[point];
    } else {
        const Wheel& wheel = parameters_.wheels[point - points];
        result.arm_B = wheel.place_B;
        result.stiffness = wheel.stiffness;
        result.damping = wheel.damping;
    }
    const Vector3 arm_N = motion.R_NB * result.arm_B;
    result.place_N = motion.position_N + arm_N;
    result.depth = result.place_N.z() - surface_z_;
    if (result.depth <= 0.0) return result;
    result.velocity_N = motion.velocity_N + motion.R_NB * motion.rate_B.cross(result.arm_B);
    const double normal = result.stiffness * result.depth + result.damping * result.velocity_N.z();
    result.normal = math::max(normal, 0.0);
    return result;
}

// How far the point stands from its anchor, along the ground.
Vector3 Ground::stretch(unsigned point, const Contact& contact) const {
    if ((touched_ & (std::uint64_t{1} << point)) == 0) return Vector3::Zero();
    const Vector3 difference = contact.place_N - anchors_N_[point];
    return Vector3(difference.x(), difference.y(), 0.0);
}

Vector3 Ground::held(unsigned point, const Motion& motion, const Vector3& wanted_N, double normal,
                     double stiffness) const {
    const auto points = static_cast<unsigned>(parameters_.points_B.size());
    const double most = parameters_.friction * normal / stiffness;
    if (point < points) return limited(wanted_N, most);
    const Wheel& wheel = parameters_.wheels[point - points];
    const Vector3 rolls_N = motion.R_NB * rolls_B_[point - points];
    const Vector3 along_N =
        math::normalized(Vector3(rolls_N.x(), rolls_N.y(), 0.0), Vector3(Vector3::UnitX()));
    const Vector3 across_N(-along_N.y(), along_N.x(), 0.0);
    const double most_along = (is_braked_ ? wheel.brake : wheel.rolling) * normal / stiffness;
    return math::clamp(wanted_N.dot(along_N), -most_along, most_along) * along_N +
           math::clamp(wanted_N.dot(across_N), -most, most) * across_N;
}

Wrench Ground::wrench(const Motion& motion) const {
    Wrench sum;
    if (!is_near(motion)) return sum;
    for (unsigned point = 0; point < parameters_.contact_count(); ++point) {
        const Contact at = contact(point, motion);
        if (at.normal <= 0.0) continue;
        const Vector3 slip_N(at.velocity_N.x(), at.velocity_N.y(), 0.0);
        const Vector3 hold_N = -at.stiffness * stretch(point, at) - at.damping * slip_N;
        const Vector3 friction_N = held(point, motion, hold_N, at.normal, 1.0);
        const Vector3 force_N(friction_N.x(), friction_N.y(), -at.normal);
        const Vector3 force_B = motion.R_NB.transpose() * force_N;
        sum.force_B += force_B;
        sum.torque_B += at.arm_B.cross(force_B);
    }
    return sum;
}

void Ground::settle(const Motion& motion) {
    if (!is_near(motion)) {
        touched_ = 0;
        return;
    }
    for (unsigned point = 0; point < parameters_.contact_count(); ++point) {
        const Contact at = contact(point, motion);
        const Vector3 kept = held(point, motion, stretch(point, at), at.normal, at.stiffness);
        touched_ &= ~(std::uint64_t{1} << point);
        if (at.depth <= 0.0) continue;
        touched_ |= std::uint64_t{1} << point;
        anchors_N_[point] = at.place_N - kept;
    }
}

}  // namespace stator::world
