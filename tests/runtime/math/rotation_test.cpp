// Rotations against their definitions: what a turn does to vectors, and that inverses invert.
#include "stator/rotation.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "stator/random.hpp"

namespace stator::math {
namespace {

template <typename T>
class Rotation : public ::testing::Test {
  protected:
    static constexpr T kTolerance = T{8} * std::numeric_limits<T>::epsilon();

    Random random_{5};

    T between(T low, T high) {
        return low + (high - low) * static_cast<T>(random_.uniform_double());
    }

    Vector3<T> any_vector() {
        Vector3<T> v;
        for (T& x : v) x = static_cast<T>(random_.gaussian_double());
        return v;
    }

    Quaternion<T> any_rotation() {
        Eigen::Matrix<T, 4, 1> v;
        for (T& x : v) x = static_cast<T>(random_.gaussian_double());
        return normalized(Quaternion<T>(v));
    }

    template <typename A>
    static std::string text(const A& vector) {
        std::ostringstream out;
        for (const T x : vector.eval()) out << x << ' ';
        return out.str();
    }

    template <typename A, typename B>
    static void expect_near(const A& a, const B& b, T tolerance = kTolerance) {
        EXPECT_LE(norm(a - b), tolerance) << text(a) << "and " << text(b);
    }

    static void expect_close(T a, T b, T tolerance) {
        EXPECT_LE(abs(a - b), tolerance) << a << " and " << b;
    }

    // q and -q are the same rotation.
    static void expect_same_rotation(const Quaternion<T>& a, const Quaternion<T>& b,
                                     T tolerance = kTolerance) {
        const T sign_of_b = a.dot(b) < T{0} ? T{-1} : T{1};
        expect_near(a.coeffs(), (b.coeffs() * sign_of_b).eval(), tolerance);
    }
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Rotation, Types, );

TYPED_TEST(Rotation, NormAndNormalized) {
    using T = TypeParam;
    using Vector = Vector3<T>;
    EXPECT_EQ(norm(Vector(2, 3, 6)), T{7});
    EXPECT_EQ(norm(Eigen::Matrix<T, 2, 1>(3, 4)), T{5});
    this->expect_near(normalized(Vector(0, -3, 4)), Vector(0, T(-0.6), T(0.8)), T(1e-6));
    const Vector fallback = Vector::UnitY();
    EXPECT_EQ(normalized(Vector(0, 0, 0), fallback), fallback);
    EXPECT_EQ(normalized(Vector(1, canonical_nan<T>(), 0), fallback), fallback);
    EXPECT_EQ(normalized(Vector(std::numeric_limits<T>::max(), 0, 0), fallback), fallback);
    EXPECT_EQ(normalized(Vector(0, 0, 0)), Vector(0, 0, 0));
    EXPECT_EQ(normalized(Quaternion<T>(0, 0, 0, 0)).w(), T{1});
    EXPECT_EQ(normalized(Quaternion<T>(0, 2, 0, 0)).x(), T{1});
}

TYPED_TEST(Rotation, ArraysHaveTheOrderOfMessages) {
    using T = TypeParam;
    const std::array<T, 3> xyz{T{1}, T{2}, T{3}};
    EXPECT_EQ(vector(xyz), Vector3<T>(1, 2, 3));
    EXPECT_EQ(to_array(vector(xyz)), xyz);
    const std::array<T, 4> wxyz{T{1}, T{2}, T{3}, T{4}};
    EXPECT_EQ(quaternion(wxyz).w(), T{1});
    EXPECT_EQ(quaternion(wxyz).z(), T{4});
    EXPECT_EQ(to_array(quaternion(wxyz)), wxyz);
}

TYPED_TEST(Rotation, SkewIsTheCrossProduct) {
    for (int i = 0; i < 100; ++i) {
        const auto a = this->any_vector();
        const auto b = this->any_vector();
        this->expect_near((skew(a) * b).eval(), a.cross(b).eval());
    }
}

// Right-handed: a quarter turn about z takes x to y; yaw turns north to east.
TYPED_TEST(Rotation, TurnsTheRightWay) {
    using T = TypeParam;
    using Vector = Vector3<T>;
    const Vector x = Vector::UnitX();
    const Vector y = Vector::UnitY();
    const Vector z = Vector::UnitZ();
    this->expect_near(from_axis_angle(z, kHalfPi<T>) * x, y);
    this->expect_near(from_rotation_vector(x * kHalfPi<T>) * y, z);
    this->expect_near(from_euler(EulerAngles<T>{T{0}, T{0}, kHalfPi<T>}) * x, y);
    this->expect_near(from_euler(EulerAngles<T>{T{0}, kHalfPi<T>, T{0}}) * x, -z);  // nose up
    this->expect_near(from_euler(EulerAngles<T>{kHalfPi<T>, T{0}, T{0}}) * y,
                      z);  // right wing down
}

TYPED_TEST(Rotation, LogInvertsExp) {
    using T = TypeParam;
    for (const T length : {T(1e-12), T(1e-5), T(1e-3), T(0.03), T(0.04), T(0.5), T(3.0), T(3.14)}) {
        for (int i = 0; i < 50; ++i) {
            const Vector3<T> vector = normalized(this->any_vector()) * length;
            const Quaternion<T> q = from_rotation_vector(vector);
            this->expect_close(norm(q.coeffs()), T{1}, this->kTolerance);
            this->expect_near(to_rotation_vector(q), vector, this->kTolerance * length);
            this->expect_near(to_rotation_vector(Quaternion<T>(-q.coeffs())), vector,
                              this->kTolerance * length);
        }
    }
    EXPECT_EQ(to_rotation_vector(Quaternion<T>::Identity()), (Vector3<T>::Zero()));
    EXPECT_EQ(from_rotation_vector(Vector3<T>(0, 0, 0)).w(), T{1});
}

TYPED_TEST(Rotation, ExpIsTheTurnAboutItsAxis) {
    using T = TypeParam;
    for (int i = 0; i < 100; ++i) {
        const Vector3<T> axis = normalized(this->any_vector());
        const T angle = this->between(T{-6}, T{6});
        this->expect_same_rotation(from_rotation_vector(axis * angle),
                                   from_axis_angle(axis, angle));
    }
}

TYPED_TEST(Rotation, EulerAnglesAreYawThenPitchThenRoll) {
    using T = TypeParam;
    for (int i = 0; i < 200; ++i) {
        const EulerAngles<T> angles{this->between(T{-3}, T{3}), this->between(T{-1.5}, T{1.5}),
                                    this->between(T{-3}, T{3})};
        const Quaternion<T> q = from_euler(angles);
        const Quaternion<T> one_by_one = from_axis_angle<T>(Vector3<T>::UnitZ(), angles.yaw) *
                                         from_axis_angle<T>(Vector3<T>::UnitY(), angles.pitch) *
                                         from_axis_angle<T>(Vector3<T>::UnitX(), angles.roll);
        this->expect_same_rotation(q, one_by_one);
        const EulerAngles<T> back = to_euler(q);
        const T tolerance = this->kTolerance * T{16};  // 1 / cos(1.5 rad) is 14
        this->expect_close(back.roll, angles.roll, tolerance);
        this->expect_close(back.pitch, angles.pitch, tolerance);
        this->expect_close(back.yaw, angles.yaw, tolerance);
        this->expect_close(heading(q), angles.yaw, tolerance);
        // Level means that both rotations about horizontal axes are 0: cos tilt = cos roll cos
        // pitch.
        this->expect_close(cos(tilt(q)), cos(angles.roll) * cos(angles.pitch), this->kTolerance);
    }
}

TYPED_TEST(Rotation, EulerAnglesAtTheSingularityStillAreTheSameRotation) {
    using T = TypeParam;
    for (const T pitch : {kHalfPi<T>, -kHalfPi<T>}) {
        for (const T roll : {T{0}, T(0.7), T{-2}}) {
            const Quaternion<T> q = from_euler(EulerAngles<T>{roll, pitch, T(0.3)});
            const EulerAngles<T> angles = to_euler(q);
            this->expect_close(angles.pitch, pitch, T(4e-3));  // sqrt(epsilon) of float is 3e-4
            this->expect_same_rotation(from_euler(angles), q, T(4e-3));
        }
    }
}

TYPED_TEST(Rotation, TiltIsSharpAtSmallAndLargeAngles) {
    using T = TypeParam;
    for (const T angle : {T{0}, T(1e-6), T{1}, kHalfPi<T>, kPi<T>}) {
        const Quaternion<T> q = from_axis_angle<T>(Vector3<T>::UnitY(), angle);
        this->expect_close(tilt(q), angle, this->kTolerance * max(angle, T(1e-6)));
    }
}

// Constant rate: many steps are one turn about the rate's axis.
TYPED_TEST(Rotation, IntegrationOfAConstantRateIsOneTurn) {
    using T = TypeParam;
    const Vector3<T> rate_B(T(0.3), T(-1.1), T(0.7));
    const Quaternion<T> start = this->any_rotation();
    Quaternion<T> q_NB = start;
    constexpr int kSteps = 1000;
    const T dt = T{1} / T{256};
    for (int i = 0; i < kSteps; ++i) q_NB = integrate(q_NB, rate_B, dt);
    const Quaternion<T> once = start * from_rotation_vector(rate_B * (T{kSteps} * dt));
    this->expect_same_rotation(q_NB, once, this->kTolerance * T{30});  // grows like sqrt(steps)
    this->expect_close(norm(q_NB.coeffs()), T{1}, this->kTolerance);
}

// The rate is that of the body, so it multiplies from the right.
TYPED_TEST(Rotation, IntegrationIsInBodyAxes) {
    using T = TypeParam;
    const Quaternion<T> east = from_euler(EulerAngles<T>{T{0}, T{0}, kHalfPi<T>});
    const Vector3<T> pitching_B(T{0}, T(0.5), T{0});
    const EulerAngles<T> after = to_euler(integrate(east, pitching_B, T(0.5)));
    this->expect_close(after.pitch, T(0.25), this->kTolerance);
    this->expect_close(after.roll, T{0}, this->kTolerance);
    this->expect_close(after.yaw, kHalfPi<T>, this->kTolerance);
}

TYPED_TEST(Rotation, FromTwoVectorsIsTheShortestTurn) {
    using T = TypeParam;
    for (int i = 0; i < 200; ++i) {
        const Vector3<T> a = this->any_vector();
        const Vector3<T> b = this->any_vector();
        const Quaternion<T> q = from_two_vectors(a, b);
        this->expect_near(q * normalized(a), normalized(b), this->kTolerance * T{4});
        // No turn about the mean direction: its axis is at right angles to both.
        this->expect_close(q.vec().dot(normalized(a)), T{0}, this->kTolerance);
        this->expect_close(q.vec().dot(normalized(b)), T{0}, this->kTolerance);
    }
}

TYPED_TEST(Rotation, FromTwoVectorsThatAreEqualOrOppositeOrZero) {
    using T = TypeParam;
    using Vector = Vector3<T>;
    for (int i = 0; i < 100; ++i) {
        const Vector a = this->any_vector();
        this->expect_near(from_two_vectors(a, a).coeffs(), Quaternion<T>::Identity().coeffs());
        this->expect_near(from_two_vectors(a, -a) * normalized(a), -normalized(a));
        const Vector almost = -a + this->any_vector() * T(1e-5);
        this->expect_near(from_two_vectors(a, almost) * normalized(a), normalized(almost), T(4e-3));
    }
    EXPECT_EQ(from_two_vectors(Vector(0, 0, 0), Vector(1, 0, 0)).w(), T{1});
}

TYPED_TEST(Rotation, FromMatrixInvertsToRotationMatrix) {
    using T = TypeParam;
    for (int i = 0; i < 500; ++i) {
        const Quaternion<T> q = this->any_rotation();
        const Quaternion<T> back = from_matrix<T>(q.toRotationMatrix());
        EXPECT_GE(back.w(), T{0});
        this->expect_same_rotation(back, q);
    }
    // Half turns, where w is 0 and each of the other components in turn is the largest.
    for (int axis = 0; axis < 3; ++axis) {
        const Quaternion<T> q = from_axis_angle<T>(Vector3<T>::Unit(axis), kPi<T>);
        this->expect_same_rotation(from_matrix<T>(q.toRotationMatrix()), q);
    }
}

TYPED_TEST(Rotation, FromBodyZAndYawPointsBoth) {
    using T = TypeParam;
    for (int i = 0; i < 200; ++i) {
        const Vector3<T> z_N = this->any_vector();
        const T yaw = this->between(T{-3}, T{3});
        const Quaternion<T> q_NB = from_body_z_and_yaw(z_N, yaw);
        this->expect_near(q_NB * Vector3<T>(Vector3<T>::UnitZ()), normalized(z_N));
        const Vector3<T> nose_N = q_NB * Vector3<T>(Vector3<T>::UnitX());
        const Vector3<T> forward_N(cos(yaw), sin(yaw), T{0});
        const Vector3<T> right_N(-sin(yaw), cos(yaw), T{0});
        EXPECT_GT(nose_N.dot(forward_N), T{0});
        this->expect_close(nose_N.dot(right_N), T{0}, this->kTolerance);
    }
}

TYPED_TEST(Rotation, FromBodyZAndYawAtItsCorners) {
    using T = TypeParam;
    using Vector = Vector3<T>;
    const Quaternion<T> level = from_body_z_and_yaw(Vector(0, 0, 0), T(0.5));
    this->expect_close(heading(level), T(0.5), this->kTolerance);
    this->expect_close(tilt(level), T{0}, this->kTolerance);
    // Right wing straight down, the nose is free: it stays on its yaw.
    const Quaternion<T> wing = from_body_z_and_yaw(Vector(0, 1, 0), T{0});
    this->expect_near(wing * Vector(0, 0, 1), Vector(0, 1, 0));
    this->expect_near(wing * Vector(1, 0, 0), Vector(1, 0, 0));
}

}  // namespace
}  // namespace stator::math
