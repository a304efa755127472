// What goes wrong in a simulated flight, and when.
#include "faults.hpp"

#include <charconv>
#include <string_view>

#include "stator/scalar.hpp"

namespace stator::board {

namespace {

constexpr double kLatest_s = 1e6;

struct Row {
    std::string_view name;
    FaultKind kind;
    double usual;  // where no value is given
    double most;   // 0: it has no value
};
constexpr std::array kRows{Row{"gnss_loss", FaultKind::kGnssLoss, 0.0, 0.0},
                           Row{"gnss_glitch", FaultKind::kGnssGlitch, 20.0, 1e5},
                           Row{"baro_loss", FaultKind::kBaroLoss, 0.0, 0.0},
                           Row{"mission_loss", FaultKind::kMissionLoss, 0.0, 0.0},
                           Row{"rc_loss", FaultKind::kRcLoss, 0.0, 0.0},
                           Row{"battery_low", FaultKind::kBatteryLow, 0.1, 1.0},
                           Row{"motor_1", FaultKind::kMotor1, 0.7, 1.0},
                           Row{"motor_2", FaultKind::kMotor2, 0.7, 1.0},
                           Row{"motor_3", FaultKind::kMotor3, 0.7, 1.0},
                           Row{"motor_4", FaultKind::kMotor4, 0.7, 1.0}};

// 0 to `most`.
std::optional<double> read(std::string_view text, double most) {
    double number = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return {};
    if (!(number >= 0.0 && number <= most)) return {};
    return number;
}

std::optional<Fault> of_name(std::string_view name, std::string_view value, bool has_value) {
    for (const Row& row : kRows) {
        if (row.name != name) continue;
        if (has_value && row.most == 0.0) return {};
        const auto number = has_value ? read(value, row.most) : row.usual;
        if (!number) return {};
        return Fault{row.kind, *number, 0, 0};
    }
    return {};
}

std::uint64_t microseconds(double seconds) {
    return math::saturate<std::uint64_t>(math::round(seconds * 1e6));
}

}  // namespace

const char* const kFaultNames =
    "gnss_loss, gnss_glitch[=METRES], baro_loss, mission_loss, rc_loss, battery_low[=0..1], "
    "motor_1 to motor_4[=0..1]";

bool Faults::add(const Fault& fault) {
    if (count_ == kMax) return false;
    faults_[count_++] = fault;
    return true;
}

std::optional<double> Faults::now(FaultKind kind, std::uint64_t time_us) const {
    std::optional<double> result;
    for (unsigned i = 0; i < count_; ++i) {
        const Fault& fault = faults_[i];
        const bool there = fault.kind == kind && time_us >= fault.from_us;
        if (there && time_us < fault.until_us) result = fault.value;
    }
    return result;
}

std::optional<Fault> read_fault(const char* text) {
    const std::string_view whole = text;
    const std::size_t at = whole.find('@');
    if (at == std::string_view::npos) return {};
    const std::string_view what = whole.substr(0, at);
    const std::string_view when = whole.substr(at + 1);
    const std::size_t equals = what.find('=');
    const bool has_value = equals != std::string_view::npos;
    auto fault =
        of_name(what.substr(0, equals), has_value ? what.substr(equals + 1) : "", has_value);
    const std::size_t plus = when.find('+');
    const auto from = read(when.substr(0, plus), kLatest_s);
    const bool for_good = plus == std::string_view::npos;
    const auto lasts = for_good ? 2.0 * kLatest_s : read(when.substr(plus + 1), kLatest_s);
    if (!fault || !from || !lasts) return {};
    fault->from_us = microseconds(*from);
    fault->until_us = microseconds(*from + *lasts);
    return fault;
}

}  // namespace stator::board
