// The covariance's three operations against the textbook's dense products in double.
#include "covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "stator/random.hpp"

namespace stator::apps::navigation {
namespace {

using Dense = Eigen::Matrix<double, kStates, kStates>;
using DenseVector = Eigen::Matrix<double, kStates, 1>;

constexpr float kStep = 0.008F;
constexpr Covariance::Noise kNoise{.turn = 1e-7F,
                                   .velocity = 1e-5F,
                                   .gyro_bias = 1e-11F,
                                   .accel_bias = 1e-9F,
                                   .baro_offset = 1e-6F,
                                   .mag_offset = 1e-8F};

Dense dense(const Covariance& p) {
    Dense result;
    for (unsigned i = 0; i < kStates; ++i)
        for (unsigned k = 0; k < kStates; ++k) result(i, k) = static_cast<double>(p(i, k));
    return result;
}

Vector random_vector(math::Random& random, float scale) {
    Vector result;
    for (int i = 0; i < 3; ++i) result(i) = scale * random.gaussian_float();
    return result;
}

// Anything in flight: a turn, a push of gravity's size and more.
struct Case {
    math::Matrix3<float> R_NB;
    Vector push_N;
};
Case random_case(math::Random& random) {
    const Quaternion q_NB = math::from_rotation_vector(random_vector(random, 1.0F));
    return {.R_NB = q_NB.toRotationMatrix(), .push_N = random_vector(random, 10.0F) * kStep};
}

void dense_predict(Dense& p, const Case& at, double time) {
    Dense f = Dense::Identity();
    const Eigen::Matrix3d R = at.R_NB.cast<double>();
    f.block<3, 3>(kPosition, kVelocity) = Eigen::Matrix3d::Identity() * time;
    f.block<3, 3>(kVelocity, kTurn) = -math::skew(Eigen::Vector3d(at.push_N.cast<double>()));
    f.block<3, 3>(kVelocity, kAccelBias) = -R * time;
    f.block<3, 3>(kTurn, kGyroBias) = -R * time;
    p = f * p * f.transpose();
    for (unsigned i = 0; i < 3; ++i) {
        p(kTurn + i, kTurn + i) += static_cast<double>(kNoise.turn);
        p(kVelocity + i, kVelocity + i) += static_cast<double>(kNoise.velocity);
        p(kGyroBias + i, kGyroBias + i) += static_cast<double>(kNoise.gyro_bias);
        p(kAccelBias + i, kAccelBias + i) += static_cast<double>(kNoise.accel_bias);
    }
    p(kBaroOffset, kBaroOffset) += static_cast<double>(kNoise.baro_offset);
    p(kMagOffset, kMagOffset) += static_cast<double>(kNoise.mag_offset);
}

// Everything correlated with everything, by some steps and measurements.
Covariance random_covariance(math::Random& random) {
    Covariance p;
    p.reset(kTurn, 3, 0.01F);
    p.reset(kVelocity, 3, 0.3F);
    p.reset(kPosition, 3, 2.0F);
    p.reset(kGyroBias, 3, 1e-4F);
    p.reset(kAccelBias, 3, 0.04F);
    p.reset(kBaroOffset, 1, 1.0F);
    p.reset(kMagOffset, 1, 0.04F);
    p.loosen(kHeading, kMagOffset, 0.02F);
    for (int step = 0; step < 200; ++step) {
        const Case at = random_case(random);
        p.predict(at.R_NB, at.push_N, kStep, kNoise);
    }
    const Covariance::Column cross =
        p.cross_covariance({static_cast<ErrorState>(kPosition + 2), -1.0F, kBaroOffset, 1.0F});
    p.correct(cross, -cross[kPosition + 2] + cross[kBaroOffset] + 0.5F, false);
    return p;
}

// Largest difference, each element against the deviations of its two states.
double difference(const Dense& found, const Dense& expected) {
    double worst = 0.0;
    for (unsigned i = 0; i < kStates; ++i) {
        for (unsigned k = 0; k < kStates; ++k) {
            const double scale = std::sqrt(expected(i, i) * expected(k, k));
            worst = std::max(worst, std::abs(found(i, k) - expected(i, k)) / scale);
        }
    }
    return worst;
}

TEST(Covariance, PredictsAsTheDenseProduct) {
    math::Random random(1);
    for (int run = 0; run < 20; ++run) {
        Covariance p = random_covariance(random);
        Dense expected = dense(p);
        const Case at = random_case(random);
        p.predict(at.R_NB, at.push_N, kStep, kNoise);
        dense_predict(expected, at, static_cast<double>(kStep));
        EXPECT_LT(difference(dense(p), expected), 2e-6);
    }
}

// Joseph's form, which is right for any gain.
TEST(Covariance, CorrectsAsTheDenseProduct) {
    math::Random random(2);
    const ObservationModel height{static_cast<ErrorState>(kPosition + 2), -1.0F, kBaroOffset, 1.0F};
    const ObservationModel heading{kHeading, 1.0F, kMagOffset, 1.0F};
    for (int run = 0; run < 20; ++run) {
        for (const bool keep_tilt : {false, true}) {
            Covariance p = random_covariance(random);
            const ObservationModel& model = keep_tilt ? heading : height;
            DenseVector h = DenseVector::Zero();
            h(model.first) = static_cast<double>(model.first_sign);
            h(model.second) = static_cast<double>(model.second_sign);
            const double noise = 0.04;
            const Dense before = dense(p);
            const double total = h.dot(before * h) + noise;
            DenseVector gain = before * h / total;
            if (keep_tilt) gain(kTurn) = gain(kTurn + 1) = 0.0;
            const Dense keep = Dense::Identity() - gain * h.transpose();
            const Dense expected =
                keep * before * keep.transpose() + noise * gain * gain.transpose();
            p.correct(p.cross_covariance(model), static_cast<float>(total), keep_tilt);
            EXPECT_LT(difference(dense(p), expected), 2e-6);
        }
    }
}

TEST(Covariance, LooseningLeavesTheSumAsItWas) {
    math::Random random(3);
    Covariance p = random_covariance(random);
    const auto sum = [&p] {
        return p(kHeading, kHeading) + 2.0F * p(kHeading, kMagOffset) + p(kMagOffset, kMagOffset);
    };
    const float before = sum();
    const float heading = p(kHeading, kHeading);
    p.loosen(kHeading, kMagOffset, 1.0F);
    EXPECT_NEAR(sum(), before, 1e-6F);
    EXPECT_FLOAT_EQ(p(kHeading, kHeading), heading + 1.0F);
}

// An hour of flight with every kind of measurement, and a long time without.
TEST(Covariance, StaysSymmetricAndPositive) {
    math::Random random(4);
    Covariance p = random_covariance(random);
    for (int step = 1; step <= 100'000; ++step) {
        const Case at = random_case(random);
        p.predict(at.R_NB, at.push_N, kStep, kNoise);
        const bool alone = step % 50'000 > 40'000;
        const unsigned kind = random.word() % 20;
        if (kind < 6 && !alone) {
            const Covariance::Column cross =
                p.cross_covariance({static_cast<ErrorState>(kVelocity + kind)});
            p.correct(cross, cross[kVelocity + kind] + 0.04F, false);
        } else if (kind == 6) {
            const Covariance::Column cross = p.cross_covariance({kHeading, 1.0F, kMagOffset, 1.0F});
            p.correct(cross, cross[kHeading] + cross[kMagOffset] + 0.01F, true);
        }
        p.limit();
        if (step % 1000 != 0) continue;
        const Dense now = dense(p);
        ASSERT_TRUE(now == now.transpose()) << "step " << step;
        const DenseVector scale = now.diagonal().cwiseSqrt().cwiseInverse();
        const Dense correlation = scale.asDiagonal() * now * scale.asDiagonal();
        const Eigen::SelfAdjointEigenSolver<Dense> solver(correlation, Eigen::EigenvaluesOnly);
        ASSERT_GT(solver.eigenvalues().minCoeff(), -1e-5) << "step " << step;
    }
}

}  // namespace
}  // namespace stator::apps::navigation
