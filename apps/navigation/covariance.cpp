// Covariance of the error state. No product of matrices larger than 3 x 3; P stays symmetric to
// the bit, because only one triangle is computed and the other one copied.
#include "covariance.hpp"

namespace stator::apps::navigation {

namespace {

// Least and largest variance of each group of states. Least: a millionth of what is flown with.
// Largest: beyond, the filter's first order says nothing, and float loses the small ones.
struct Limits {
    unsigned first;
    unsigned count;
    float least;
    float most;
};
constexpr std::array<Limits, 7> kLimits{{
    {kTurn, 3, 1e-8F, 4.0F},
    {kVelocity, 3, 1e-6F, 1e4F},
    {kPosition, 3, 1e-6F, 1e7F},
    {kGyroBias, 3, 1e-12F, 1.0F},
    {kAccelBias, 3, 1e-8F, 10.0F},
    {kBaroOffset, 1, 1e-6F, 1e6F},
    {kMagOffset, 1, 1e-8F, 4.0F},
}};

}  // namespace

void Covariance::reset(unsigned first, unsigned count, float variance) {
    for (unsigned row = first; row < first + count; ++row) {
        for (unsigned column = 0; column < kStates; ++column)
            p_[row][column] = p_[column][row] = 0.0F;
        p_[row][row] = variance;
    }
}

void Covariance::level(const math::Matrix3<float>& R_NB, float gravity, float bias_variance,
                       float tilt_variance) {
    const float shared = bias_variance / gravity;
    reset(kTurn, 2, tilt_variance + shared / gravity);
    reset(kAccelBias, 3, bias_variance);
    // gravity (-turn_east, turn_north) = R_NB bias, in its first two rows.
    for (unsigned axis = 0; axis < 3; ++axis) {
        p_[kTurn][kAccelBias + axis] = p_[kAccelBias + axis][kTurn] = shared * R_NB(1, axis);
        p_[kTurn + 1][kAccelBias + axis] = p_[kAccelBias + axis][kTurn + 1] =
            -shared * R_NB(0, axis);
    }
}

void Covariance::loosen(unsigned first, unsigned second, float variance) {
    p_[first][first] += variance;
    p_[second][second] += variance;
    p_[first][second] -= variance;
    p_[second][first] = p_[first][second];
}

void Covariance::predict(const math::Matrix3<float>& R_NB, const Vector& push_N, float time,
                         const Noise& noise) {
    const math::Matrix3<float> bias_to_turn = R_NB * -time;
    drift(time);
    transform(kVelocity, kTurn, math::skew(Vector(-push_N)));
    transform(kVelocity, kAccelBias, bias_to_turn);
    transform(kTurn, kGyroBias, bias_to_turn);
    for (unsigned axis = 0; axis < 3; ++axis) {
        p_[kTurn + axis][kTurn + axis] += noise.turn;
        p_[kVelocity + axis][kVelocity + axis] += noise.velocity;
        p_[kGyroBias + axis][kGyroBias + axis] += noise.gyro_bias;
        p_[kAccelBias + axis][kAccelBias + axis] += noise.accel_bias;
    }
    p_[kBaroOffset][kBaroOffset] += noise.baro_offset;
    p_[kMagOffset][kMagOffset] += noise.mag_offset;
}

// F P F' for F = 1 + a at (to, from).
void Covariance::transform(unsigned to, unsigned from, const math::Matrix3<float>& a) {
    for (unsigned column = 0; column < kStates; ++column) {
        const float x = p_[from][column];
        const float y = p_[from + 1][column];
        const float z = p_[from + 2][column];
        p_[to][column] += a(0, 0) * x + a(0, 1) * y + a(0, 2) * z;
        p_[to + 1][column] += a(1, 0) * x + a(1, 1) * y + a(1, 2) * z;
        p_[to + 2][column] += a(2, 0) * x + a(2, 1) * y + a(2, 2) * z;
    }
    for (unsigned i = 0; i < 3; ++i) {
        const Column& row = p_[to + i];
        for (unsigned k = i; k < 3; ++k)
            p_[to + i][to + k] +=
                row[from] * a(k, 0) + row[from + 1] * a(k, 1) + row[from + 2] * a(k, 2);
    }
    mirror(to);
}

// The same for position and velocity, where a is a multiple of the identity.
void Covariance::drift(float time) {
    for (unsigned i = 0; i < 3; ++i) {
        for (unsigned column = 0; column < kStates; ++column)
            p_[kPosition + i][column] += time * p_[kVelocity + i][column];
    }
    for (unsigned i = 0; i < 3; ++i) {
        for (unsigned k = i; k < 3; ++k)
            p_[kPosition + i][kPosition + k] += time * p_[kPosition + i][kVelocity + k];
    }
    mirror(kPosition);
}

void Covariance::mirror(unsigned first) {
    p_[first + 1][first] = p_[first][first + 1];
    p_[first + 2][first] = p_[first][first + 2];
    p_[first + 2][first + 1] = p_[first + 1][first + 2];
    for (unsigned column = 0; column < kStates; ++column) {
        p_[column][first] = p_[first][column];
        p_[column][first + 1] = p_[first + 1][column];
        p_[column][first + 2] = p_[first + 2][column];
    }
}

Covariance::Column Covariance::cross_covariance(const ObservationModel& model) const {
    Column result;
    for (unsigned i = 0; i < kStates; ++i) {
        result[i] = model.first_sign * p_[model.first][i] + model.second_sign * p_[model.second][i];
    }
    return result;
}

void Covariance::correct(const Column& cross, float variance, bool keep_tilt) {
    const float north = p_[kTurn][kTurn];
    const float east = p_[kTurn + 1][kTurn + 1];
    const float both = p_[kTurn][kTurn + 1];
    const float inverse = 1.0F / variance;
    for (unsigned row = 0; row < kStates; ++row) {
        const float gain = cross[row] * inverse;
        Column& across = p_[row];
        for (unsigned column = row; column < kStates; ++column) {
            const float value = across[column] - gain * cross[column];
            across[column] = value;
            p_[column][row] = value;
        }
    }
    if (!keep_tilt) return;
    // P - K H P - P H' K' + K variance K' is P - cross cross' / variance wherever one of the two
    // gains is the optimal one, and P where both are zero.
    p_[kTurn][kTurn] = north;
    p_[kTurn + 1][kTurn + 1] = east;
    p_[kTurn][kTurn + 1] = p_[kTurn + 1][kTurn] = both;
}

void Covariance::limit() {
    for (const Limits& limits : kLimits) {
        for (unsigned i = limits.first; i < limits.first + limits.count; ++i) {
            if (p_[i][i] < limits.least) p_[i][i] = limits.least;
            if (p_[i][i] <= limits.most) continue;
            // Scaled with its whole row and column, so that all correlations stay.
            const float scale = math::sqrt(limits.most / p_[i][i]);
            for (unsigned k = 0; k < kStates; ++k) {
                p_[i][k] *= scale;
                p_[k][i] = p_[i][k];
            }
            p_[i][i] = limits.most;
        }
    }
}

}  // namespace stator::apps::navigation
