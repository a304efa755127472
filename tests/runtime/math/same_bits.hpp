// Hashes over the results of every function: equal hashes mean equal bits.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace stator::math {

struct NamedHash {
    std::string name;
    std::uint64_t hash;
};

// In a fixed order; the same on every machine, with every compiler at every level.
std::vector<NamedHash> result_hashes();

}  // namespace stator::math
