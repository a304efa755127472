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

Ground::Ground(const GroundParameters& parameters, double surface_z)
    : parameters_(parameters), surface_z_(surface_z), reach_(farthest(parameters.points_B)) {
    anchors_N_.fill(Vector3::Zero());
}

bool Ground::is_near(const Motion& motion) const {
    return motion.position_N.z() + reach_ > surface_z_;
}

Ground::Contact Ground::contact(unsigned point, const Motion& motion) const {
    Contact result;
    result.arm_B = parameters_.points_B[point];
    const Vector3 arm_N = motion.R_NB * result.arm_B;
    result.place_N = motion.position_N + arm_N;
    result.depth = result.place_N.z() - surface_z_;
    if (result.depth <= 0.0) return result;
    result.velocity_N = motion.velocity_N + motion.R_NB * motion.rate_B.cross(result.arm_B);
    const double normal =
        parameters_.stiffness * result.depth + parameters_.damping * result.velocity_N.z();
    result.normal = math::max(normal, 0.0);
    return result;
}

// How far the point stands from its anchor, along the ground.
Vector3 Ground::stretch(unsigned point, const Contact& contact) const {
    if ((touched_ & (1U << point)) == 0) return Vector3::Zero();
    const Vector3 difference = contact.place_N - anchors_N_[point];
    return Vector3(difference.x(), difference.y(), 0.0);
}

Wrench Ground::wrench(const Motion& motion) const {
    Wrench sum;
    if (!is_near(motion)) return sum;
    for (unsigned point = 0; point < parameters_.points_B.size(); ++point) {
        const Contact at = contact(point, motion);
        if (at.normal <= 0.0) continue;
        const Vector3 slip_N(at.velocity_N.x(), at.velocity_N.y(), 0.0);
        const Vector3 hold_N =
            -parameters_.stiffness * stretch(point, at) - parameters_.damping * slip_N;
        const Vector3 friction_N = limited(hold_N, parameters_.friction * at.normal);
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
    for (unsigned point = 0; point < parameters_.points_B.size(); ++point) {
        const Contact at = contact(point, motion);
        const Vector3 kept =
            limited(stretch(point, at), parameters_.friction * at.normal / parameters_.stiffness);
        touched_ &= ~(1U << point);
        if (at.depth <= 0.0) continue;
        touched_ |= 1U << point;
        anchors_N_[point] = at.place_N - kept;
    }
}

}  // namespace stator::world
