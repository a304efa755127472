// The true flight as a file.
#include "truth.hpp"

#include <bit>

namespace stator::board {

static_assert(std::endian::native == std::endian::little);

bool write_truth(std::FILE* file, const Plant& plant) {
    const QuadState& state = plant.state();
    const std::array<double, kTruthColumns> row{static_cast<double>(plant.time_us()),
                                                state.position_N.x(),
                                                state.position_N.y(),
                                                state.position_N.z(),
                                                state.velocity_N.x(),
                                                state.velocity_N.y(),
                                                state.velocity_N.z(),
                                                state.q_NB.w(),
                                                state.q_NB.x(),
                                                state.q_NB.y(),
                                                state.q_NB.z(),
                                                state.rate_B.x(),
                                                state.rate_B.y(),
                                                state.rate_B.z(),
                                                plant.is_on_ground() ? 1.0 : 0.0};
    return std::fwrite(row.data(), sizeof(double), row.size(), file) == row.size();
}

}  // namespace stator::board
