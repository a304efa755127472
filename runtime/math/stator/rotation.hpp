// Rotations over Eigen's fixed-size types, for float nodes and the double plant.
//
// Quaternions are Hamilton's, q_NB turns body coordinates into local ones: v_N = R_NB * v_B.
// N is north-east-down, B forward-right-down. Euler angles are for people: yaw about z, then pitch
// about the new y, then roll about the new x.
//
// What Eigen does with + - * / alone is used as it is: products, conjugate(), toRotationMatrix().
// Never call norm(), normalize(), slerp(), AngleAxis, FromTwoVectors, eulerAngles() or
// Quaternion(matrix): they call the C library, whose last bits differ between machines.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <type_traits>

#include "stator/scalar.hpp"

namespace stator::math {

template <std::floating_point T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <std::floating_point T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;
template <std::floating_point T>
using Quaternion = Eigen::Quaternion<T>;

// The vector that an Eigen expression stands for, so that norm(a - b) needs no cast.
template <typename Derived>
using Plain = typename Derived::PlainObject;

// Radians. From to_euler: roll and yaw in [-pi, pi], pitch in [-pi/2, pi/2].
template <std::floating_point T>
struct EulerAngles {
    T roll;
    T pitch;
    T yaw;
};

// Between the arrays of messages and vectors.
template <std::floating_point T>
Vector3<T> vector(const std::array<T, 3>& xyz) {
    return Vector3<T>(xyz[0], xyz[1], xyz[2]);
}
template <std::floating_point T>
std::array<T, 3> to_array(const Vector3<T>& v) {
    return {v.x(), v.y(), v.z()};
}
// Order w x y z, as in messages.
template <std::floating_point T>
Quaternion<T> quaternion(const std::array<T, 4>& wxyz) {
    return Quaternion<T>(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}
template <std::floating_point T>
std::array<T, 4> to_array(const Quaternion<T>& q) {
    return {q.w(), q.x(), q.y(), q.z()};
}

// Euclidean length. Overflows and underflows as its square does.
template <typename Derived>
typename Derived::Scalar norm(const Eigen::MatrixBase<Derived>& v) {
    return sqrt(v.squaredNorm());
}

// v at length 1; `fallback` if v is zero, not finite, or so short or long that its square is.
template <typename Derived>
Plain<Derived> normalized(const Eigen::MatrixBase<Derived>& v, const Plain<Derived>& fallback) {
    using T = typename Derived::Scalar;
    const Plain<Derived> vector = v;
    const T squared = vector.squaredNorm();
    if (!(squared >= std::numeric_limits<T>::min()) || !is_finite(squared)) return fallback;
    return vector / sqrt(squared);
}

template <typename Derived>
Plain<Derived> normalized(const Eigen::MatrixBase<Derived>& v) {
    return normalized(v, Plain<Derived>(Plain<Derived>::Zero()));
}

// q at length 1; the identity where a vector would give its fallback.
template <typename T>
Quaternion<T> normalized(const Quaternion<T>& q) {
    return Quaternion<T>(normalized(q.coeffs(), Quaternion<T>::Identity().coeffs()));
}

// The same rotation with w >= 0, the shorter way round.
template <typename T>
Quaternion<T> shortest(const Quaternion<T>& q) {
    return q.w() < T{0} ? Quaternion<T>(-q.coeffs()) : q;
}

// skew(a) * b = a x b.
template <typename Derived>
Matrix3<typename Derived::Scalar> skew(const Eigen::MatrixBase<Derived>& vector) {
    using T = typename Derived::Scalar;
    const Vector3<T> a = vector;
    Matrix3<T> result;
    result << T{0}, -a.z(), a.y(), a.z(), T{0}, -a.x(), -a.y(), a.x(), T{0};
    return result;
}

// Exponential map: the turn by |v| radians about v. A NaN where the square of v overflows.
template <typename Derived>
Quaternion<typename Derived::Scalar> from_rotation_vector(const Eigen::MatrixBase<Derived>& v) {
    using T = typename Derived::Scalar;
    const Vector3<T> vector = v;
    const T squared_angle = vector.squaredNorm();
    // Below, sin(a/2)/a and cos(a/2) are their first Taylor terms to within rounding.
    constexpr T kSmall = std::numeric_limits<T>::digits == 24 ? T{0x1p-10} : T{0x1p-24};
    if (squared_angle < kSmall) {
        const T scale = T{0.5} - squared_angle / T{48};
        const Vector3<T> xyz = vector * scale;
        return normalized(Quaternion<T>(T{1} - squared_angle / T{8}, xyz.x(), xyz.y(), xyz.z()));
    }
    const T angle = sqrt(squared_angle);
    const SinCos<T> half = sincos(T{0.5} * angle);
    const Vector3<T> xyz = vector * (half.sin / angle);
    return Quaternion<T>(half.cos, xyz.x(), xyz.y(), xyz.z());
}

// Logarithm: the rotation vector of a unit quaternion, the shorter way round, length at most pi.
template <typename T>
Vector3<T> to_rotation_vector(const Quaternion<T>& q) {
    const Quaternion<T> near = shortest(q);
    const Vector3<T> xyz = near.vec();
    const T sin_half = norm(xyz);
    if (sin_half < std::numeric_limits<T>::epsilon()) return xyz * T{2};
    return xyz * (T{2} * atan2(sin_half, near.w()) / sin_half);
}

// `axis` of unit length.
template <typename T>
Quaternion<T> from_axis_angle(const Vector3<T>& axis, T angle) {
    const SinCos<T> half = sincos(T{0.5} * angle);
    return Quaternion<T>(half.cos, half.sin * axis.x(), half.sin * axis.y(), half.sin * axis.z());
}

template <typename T>
Quaternion<T> from_euler(const EulerAngles<T>& angles) {
    const SinCos<T> r = sincos(T{0.5} * angles.roll);
    const SinCos<T> p = sincos(T{0.5} * angles.pitch);
    const SinCos<T> y = sincos(T{0.5} * angles.yaw);
    return Quaternion<T>(y.cos * p.cos * r.cos + y.sin * p.sin * r.sin,
                         y.cos * p.cos * r.sin - y.sin * p.sin * r.cos,
                         y.cos * p.sin * r.cos + y.sin * p.cos * r.sin,
                         y.sin * p.cos * r.cos - y.cos * p.sin * r.sin);
}

// Yaw of a unit quaternion: where the nose points, from north over east. With the nose straight up
// or down there is none, and this is any angle.
template <typename T>
T heading(const Quaternion<T>& q_NB) {
    return atan2(T{2} * (q_NB.w() * q_NB.z() + q_NB.x() * q_NB.y()),
                 T{1} - T{2} * (square(q_NB.y()) + square(q_NB.z())));
}

// With the nose straight up or down, one of many that are right. By half sum s and half difference
// d of yaw and roll: (w + y, z - x) = (cos p/2 + sin p/2) (cos d, sin d), and (w - y, z + x) = (cos
// p/2 - sin p/2) (cos s, sin s), from the products in from_euler.
template <typename T>
EulerAngles<T> to_euler(const Quaternion<T>& q_NB) {
    const Eigen::Matrix<T, 2, 1> up(q_NB.w() + q_NB.y(), q_NB.z() - q_NB.x());
    const Eigen::Matrix<T, 2, 1> down(q_NB.w() - q_NB.y(), q_NB.z() + q_NB.x());
    const T half_sum = atan2(down.y(), down.x());
    const T half_difference = atan2(up.y(), up.x());
    return {wrap_pi(half_sum - half_difference), T{2} * atan2(norm(up), norm(down)) - kHalfPi<T>,
            wrap_pi(half_sum + half_difference)};
}

// Angle between the body's z axis and the local one, in [0, pi]: 0 when level.
template <typename T>
T tilt(const Quaternion<T>& q_NB) {
    const T sin_half = sqrt(square(q_NB.x()) + square(q_NB.y()));
    const T cos_half = sqrt(square(q_NB.w()) + square(q_NB.z()));
    return T{2} * atan2(sin_half, cos_half);
}

// Attitude after `dt` seconds at the constant rate of B against N, in rad/s in B; unit length.
template <typename T>
Quaternion<T> integrate(const Quaternion<T>& q_NB, const std::type_identity_t<Vector3<T>>& rate_B,
                        std::type_identity_t<T> dt) {
    return normalized(q_NB * from_rotation_vector(rate_B * dt));
}

// The shortest turn that takes the direction of `from` to that of `to`; for opposite directions
// half a turn about an axis at right angles; the identity if either has no direction.
template <typename From, typename To>
Quaternion<typename From::Scalar> from_two_vectors(const Eigen::MatrixBase<From>& from,
                                                   const Eigen::MatrixBase<To>& to) {
    using T = typename From::Scalar;
    const Vector3<T> a = normalized(from);
    const Vector3<T> b = normalized(to);
    // a + b is 2 cos(angle/2) long: near zero, the half-way vector is lost in rounding.
    const Vector3<T> sum = a + b;
    if (sum.squaredNorm() > T{16} * std::numeric_limits<T>::epsilon()) {
        const Vector3<T> half_way = normalized(sum);
        const Vector3<T> xyz = a.cross(half_way);
        return normalized(Quaternion<T>(a.dot(half_way), xyz.x(), xyz.y(), xyz.z()));
    }
    if (!(a.squaredNorm() > T{0} && b.squaredNorm() > T{0})) return Quaternion<T>::Identity();
    const Vector3<T> other = abs(a.x()) < T{0.625} ? Vector3<T>::UnitX() : Vector3<T>::UnitY();
    const Vector3<T> axis = normalized(a.cross(other));
    return Quaternion<T>(T{0}, axis.x(), axis.y(), axis.z());
}

// Of a rotation matrix (Shepperd 1978: divides by the largest component). Unit length, w >= 0.
template <typename T>
Quaternion<T> from_matrix(const Matrix3<T>& R) {
    const T trace = R(0, 0) + R(1, 1) + R(2, 2);
    Quaternion<T> q;
    if (trace >= R(0, 0) && trace >= R(1, 1) && trace >= R(2, 2)) {
        q = Quaternion<T>(T{1} + trace, R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    } else if (R(0, 0) >= R(1, 1) && R(0, 0) >= R(2, 2)) {
        q = Quaternion<T>(R(2, 1) - R(1, 2), T{1} + R(0, 0) - R(1, 1) - R(2, 2), R(0, 1) + R(1, 0),
                          R(0, 2) + R(2, 0));
    } else if (R(1, 1) >= R(2, 2)) {
        q = Quaternion<T>(R(0, 2) - R(2, 0), R(0, 1) + R(1, 0), T{1} - R(0, 0) + R(1, 1) - R(2, 2),
                          R(1, 2) + R(2, 1));
    } else {
        q = Quaternion<T>(R(1, 0) - R(0, 1), R(0, 2) + R(2, 0), R(1, 2) + R(2, 1),
                          T{1} - R(0, 0) - R(1, 1) + R(2, 2));
    }
    return shortest(normalized(q));
}

// The attitude whose body z axis is `z_N` and whose nose lies in the vertical plane through `yaw`,
// in front even when upside down: a multirotor's thrust acts along -z. Level, if z_N has no
// direction.
template <typename T>
Quaternion<T> from_body_z_and_yaw(const Vector3<T>& z_N, T yaw) {
    const SinCos<T> heading = sincos(yaw);
    const Vector3<T> forward_N(heading.cos, heading.sin, T{0});
    const Vector3<T> right_N(-heading.sin, heading.cos, T{0});
    const Vector3<T> z = normalized(z_N, Vector3<T>(Vector3<T>::UnitZ()));
    // With the wing straight down or up, the nose is all that is left to choose.
    const Vector3<T> x = normalized(right_N.cross(z), forward_N) * (z.z() < T{0} ? T{-1} : T{1});
    const Vector3<T> y = z.cross(x);
    Matrix3<T> R_NB;
    R_NB << x, y, z;
    return from_matrix(R_NB);
}

}  // namespace stator::math
