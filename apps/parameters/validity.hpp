// Which values a parameter can have.
#pragma once

#include <bit>

#include "parameters_ports.hpp"
#include "stator/math/bits.hpp"

namespace stator::apps::parameters {

inline float as_float(ParameterBits value) {
    return std::bit_cast<float>(value);
}
inline int32_t as_int(ParameterBits value) {
    return std::bit_cast<int32_t>(value);
}

// NaN is in no range.
inline bool is_in_range(const ParameterRow& row, ParameterBits value) {
    if (row.type == ParameterType::kFloat) {
        return as_float(value) >= as_float(row.least) && as_float(value) <= as_float(row.most);
    }
    return as_int(value) >= as_int(row.least) && as_int(value) <= as_int(row.most);
}

}  // namespace stator::apps::parameters
