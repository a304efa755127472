// The air's force on a wing with its tail and control surfaces.
#include "world/wing.hpp"

#include <cstddef>

namespace stator::world {

namespace {

constexpr double kLeastSpeed = 0.01;     // m/s; slower, the air does nothing
constexpr double kLeastRateSpeed = 1.0;  // m/s, by which rates are counted

// How the air meets the wing.
struct Flow {
    double speed;
    double pressure;  // Pa
    double alpha;
    double beta;
    double sin_alpha;
    double cos_alpha;
    double sin_beta;
    double cos_beta;
    Vector3 rates;  // p b / 2V, q c / 2V, r b / 2V
};

Flow flow_of(const Wing& wing, const Vector3& velocity_B, const Vector3& rate_B, double speed,
             double air_density) {
    const double across = velocity_B.y();
    const double plane2 = velocity_B.x() * velocity_B.x() + velocity_B.z() * velocity_B.z();
    const double in_plane = math::sqrt(plane2);
    const bool is_sideways = in_plane < kLeastSpeed;
    const double per_speed = 0.5 / math::max(speed, kLeastRateSpeed);
    const Vector3 lengths(wing.span, wing.chord, wing.span);
    return {.speed = speed,
            .pressure = 0.5 * air_density * speed * speed,
            .alpha = is_sideways ? 0.0 : math::atan2(velocity_B.z(), velocity_B.x()),
            .beta = math::atan2(across, in_plane),
            .sin_alpha = is_sideways ? 0.0 : velocity_B.z() / in_plane,
            .cos_alpha = is_sideways ? 1.0 : velocity_B.x() / in_plane,
            .sin_beta = across / speed,
            .cos_beta = in_plane / speed,
            .rates = per_speed * rate_B.cwiseProduct(lengths)};
}

double lateral(const Lateral& by, const Flow& flow) {
    return by.beta * flow.beta + by.roll_rate * flow.rates.x() + by.yaw_rate * flow.rates.z();
}

StallPoint on_curve(const std::vector<StallPoint>& curve, double alpha) {
    std::size_t next = 1;
    while (next + 1 < curve.size() && curve[next].alpha < alpha) ++next;
    const StallPoint& a = curve[next - 1];
    const StallPoint& b = curve[next];
    const double part = math::clamp((alpha - a.alpha) / (b.alpha - a.alpha), 0.0, 1.0);
    return {.alpha = alpha,
            .lift = a.lift + part * (b.lift - a.lift),
            .drag = a.drag + part * (b.drag - a.drag),
            .pitch = a.pitch + part * (b.pitch - a.pitch)};
}

struct Coefficients {
    double lift = 0.0;
    double drag = 0.0;
    double side = 0.0;
    Vector3 moment = Vector3::Zero();  // roll, pitch, yaw
};

// What the surfaces add.
Coefficients of_surfaces(const Wing& wing, const Deflections& deflections, double alpha) {
    Coefficients sum;
    for (std::size_t i = 0; i < wing.surfaces.size(); ++i) {
        const double deflection = deflections[i];
        if (deflection == 0.0) continue;
        const Surface& surface = wing.surfaces[i];
        const double felt = surface.fades.part(alpha) * deflection;
        sum.lift += surface.lift * felt;
        sum.drag += surface.drag * math::abs(deflection) + surface.drag2 * deflection * deflection;
        sum.side += surface.side * felt;
        sum.moment += felt * Vector3(surface.roll, surface.pitch, surface.yaw);
    }
    return sum;
}

// How much of the curve there is, smoothly from 0 to 1.
double stalled_part(const Wing& wing, double alpha) {
    const double s = math::clamp((alpha - wing.stall_begins) / wing.stall_blend, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

Coefficients coefficients(const Wing& wing, const Deflections& deflections, const Flow& flow) {
    const double steep = math::abs(flow.alpha);
    Coefficients sum = of_surfaces(wing, deflections, steep);
    const double more_lift = sum.lift + wing.lift_pitch_rate * flow.rates.y();
    double lift = wing.lift_zero + wing.lift_alpha * flow.alpha;
    double drag = wing.drag_zero +
                  wing.drag_lift2 * math::square(lift + more_lift - wing.drag_least_lift) +
                  flow.alpha * (wing.drag_alpha + wing.drag_alpha2 * flow.alpha);
    double pitch = wing.pitch_zero + wing.pitch_alpha * flow.alpha;
    const double stalled = stalled_part(wing, steep);
    if (stalled > 0.0) {
        const StallPoint at = on_curve(wing.curve, steep);
        const double sign = flow.alpha < 0.0 ? -1.0 : 1.0;
        lift += stalled * (sign * at.lift - lift);
        drag += stalled * (at.drag - drag);
        pitch += stalled * (sign * at.pitch - pitch);
    }
    Lateral roll = wing.roll;
    roll.roll_rate *= wing.roll_damping.part(steep);
    sum.lift = lift + more_lift;
    sum.drag += drag + flow.beta * (wing.drag_beta + wing.drag_beta2 * flow.beta);
    sum.side += lateral(wing.side, flow);
    sum.moment += Vector3(lateral(roll, flow), pitch + wing.pitch_pitch_rate * flow.rates.y(),
                          lateral(wing.yaw, flow));
    return sum;
}

}  // namespace

double Fading::part(double alpha) const {
    if (alpha <= from) return 1.0;
    if (alpha >= to) return left;
    return 1.0 + (left - 1.0) * (alpha - from) / (to - from);
}

Wrench wing_wrench(const Wing& wing, const Deflections& deflections, const Vector3& velocity_B,
                   const Vector3& rate_B, double air_density) {
    const double speed = math::norm(velocity_B);
    if (speed < kLeastSpeed) return {};
    const Flow flow = flow_of(wing, velocity_B, rate_B, speed, air_density);
    const Coefficients by = coefficients(wing, deflections, flow);
    const double size = flow.pressure * wing.area;
    // Wind axes: x along the velocity, z in the plane of symmetry.
    const double along = -by.drag * flow.cos_beta - by.side * flow.sin_beta;
    const Vector3 force_B = size * Vector3(along * flow.cos_alpha + by.lift * flow.sin_alpha,
                                           by.side * flow.cos_beta - by.drag * flow.sin_beta,
                                           along * flow.sin_alpha - by.lift * flow.cos_alpha);
    const Vector3 lengths(wing.span, wing.chord, wing.span);
    const Vector3 torque_B =
        size * by.moment.cwiseProduct(lengths) + wing.reference_B.cross(force_B);
    return {force_B, torque_B};
}

void move_servos(const Wing& wing, const ServoControls& control, double dt,
                 Deflections& deflections) {
    for (std::size_t i = 0; i < wing.surfaces.size(); ++i) {
        const Surface& servo = wing.surfaces[i];
        const double wanted =
            math::is_nan(control[i]) ? 0.0 : servo.most * static_cast<double>(control[i]);
        const double error = math::clamp(wanted, servo.least, servo.most) - deflections[i];
        const double step = error * dt / (servo.time_constant + dt);
        const double most = servo.rate * dt;
        deflections[i] += math::clamp(step, -most, most);
    }
}

}  // namespace stator::world
