// What parameters are before anything runs. The program of a host holds them as variables, so that
// an option may replace the graph's values; firmware has them as constants.
#pragma once

#include <cstdint>
#include <cstring>

#include "stator/parameters.hpp"

namespace stator {

struct StartValue {
    const char* name;  // NODE.PARAMETER
    ParameterType type;
    void* value;  // in the message that is published first
};

// Generated for hosts: parameters of all nodes, in the order of the graph.
struct StartValues {
    const StartValue* rows;
    uint32_t count;
};
extern const StartValues start_values;

inline ParameterBits bits_of(const StartValue& row) {
    if (row.type == ParameterType::kBool) return *static_cast<const bool*>(row.value) ? 1 : 0;
    ParameterBits bits = 0;
    std::memcpy(&bits, row.value, sizeof bits);
    return bits;
}

}  // namespace stator
