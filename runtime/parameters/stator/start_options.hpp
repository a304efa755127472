// The option --param of a host program: another value of a parameter, before anything runs.
#pragma once

#include <charconv>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <system_error>

#include "stator/start_values.hpp"

namespace stator {

namespace start_options {

template <class Number>
bool read(std::string_view text, void* value) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return false;
    std::memcpy(value, &number, sizeof number);
    return true;
}

inline bool read_flag(std::string_view text, void* value) {
    if (text != "true" && text != "false") return false;
    *static_cast<bool*>(value) = text == "true";
    return true;
}

// NODE.PARAMETER=VALUE. The command line checks range and unit; here only what can be read counts.
inline bool replace(std::string_view text) {
    const size_t end = text.find('=');
    if (end == text.npos) return false;
    const std::string_view value = text.substr(end + 1);
    for (uint32_t i = 0; i < start_values.count; ++i) {
        const StartValue& row = start_values.rows[i];
        if (text.substr(0, end) != row.name) continue;
        if (row.type == ParameterType::kFloat) return read<float>(value, row.value);
        if (row.type == ParameterType::kInt32) return read<int32_t>(value, row.value);
        return read_flag(value, row.value);
    }
    return false;
}

}  // namespace start_options

// Applies and removes each pair `--param NODE.PARAMETER=VALUE` of a command line. False after one
// line on standard error about one that is wrong. Call it before the graph starts.
[[nodiscard]] inline bool take_start_values(int& count, char** arguments) {
    int kept = 1;
    for (int i = 1; i < count; ++i) {
        if (std::string_view(arguments[i]) != "--param" || i + 1 == count) {
            arguments[kept++] = arguments[i];
            continue;
        }
        if (!start_options::replace(arguments[++i])) {
            std::fprintf(stderr, "error: --param: expected NODE.PARAMETER=VALUE, found '%s'\n",
                         arguments[i]);
            return false;
        }
    }
    count = kept;
    return true;
}

}  // namespace stator
