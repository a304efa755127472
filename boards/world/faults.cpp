// What goes wrong in a simulated flight, and when.
#include "world/faults.hpp"

#include <charconv>
#include <string_view>

#include "stator/scalar.hpp"
#include "world/plant.hpp"

namespace stator::world {

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
                           Row{"battery_low", FaultKind::kBatteryLow, 0.1, 1.0}};
// Of `motor_1` and so on, without a fault's name.
constexpr Row kMotorRow{"motor_", FaultKind::kPartial, 0.7, 1.0};

constexpr double kMostOfPart = 1e6;
// Names that end in others come first.
constexpr std::array kPartRows{Row{"wrong_sign", FaultKind::kWrongSign, 0.0, 0.0},
                               Row{"swapped_axis", FaultKind::kSwappedAxis, 0.0, 0.0},
                               Row{"stuck_stick", FaultKind::kStuckStick, 0.0, 0.0},
                               Row{"static_blocked", FaultKind::kStaticBlocked, 0.0, 0.0},
                               Row{"motor_stuck", FaultKind::kMotorStuck, 0.0, 0.0},
                               Row{"weak_supply", FaultKind::kWeakSupply, 20.0, kMostOfPart},
                               Row{"saturation", FaultKind::kSaturation, 1.0, kMostOfPart},
                               Row{"time_jump", FaultKind::kTimeJump, 0.5, kMostOfPart},
                               Row{"drop_out", FaultKind::kDropOut, 0.0, 0.0},
                               Row{"blocked", FaultKind::kPitotBlocked, 0.0, 0.0},
                               Row{"trapped", FaultKind::kPitotTrapped, 0.0, 0.0},
                               Row{"silence", FaultKind::kSilence, 0.0, 0.0},
                               Row{"partial", FaultKind::kPartial, 0.5, 1.0},
                               Row{"offset", FaultKind::kOffset, 1.0, kMostOfPart},
                               Row{"preset", FaultKind::kPreset, 0.0, 0.0},
                               Row{"drift", FaultKind::kDrift, 0.1, kMostOfPart},
                               Row{"stuck", FaultKind::kStuck, 0.0, 0.0},
                               Row{"noise", FaultKind::kNoise, 1.0, kMostOfPart},
                               Row{"spike", FaultKind::kSpike, 10.0, kMostOfPart},
                               Row{"delay", FaultKind::kDelay, 0.3, 60.0},
                               Row{"speed", FaultKind::kWindSpeed, 10.0, 100.0},
                               Row{"freeze", FaultKind::kFreeze, 0.0, 0.0},
                               Row{"kill", FaultKind::kKill, 0.0, 0.0},
                               Row{"cut", FaultKind::kCut, 0.0, 0.0},
                               Row{"hang", FaultKind::kHang, 0.0, 0.0},
                               Row{"dead", FaultKind::kDead, 0.0, 0.0},
                               Row{"loss", FaultKind::kLoss, 0.0, 0.0},
                               Row{"ice", FaultKind::kIce, 30.0, kMostOfPart},
                               Row{"sag", FaultKind::kSag, 0.8, 1.0}};

std::optional<double> read(std::string_view text, double least, double most) {
    double number = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return {};
    if (!(number >= least && number <= most)) return {};
    return number;
}

std::optional<double> value_of(const Row& row, std::string_view value, bool has_value) {
    if (has_value && row.most == 0.0) return {};
    if (!has_value) return row.usual;
    const bool is_signed = row.kind == FaultKind::kOffset || row.kind == FaultKind::kDrift ||
                           row.kind == FaultKind::kSpike;
    return read(value, is_signed ? -row.most : 0.0, row.most);
}

bool copy(std::string_view text, std::array<char, Fault::kLongestName>& name) {
    if (text.size() >= name.size()) return false;
    text.copy(name.data(), text.size());
    return true;
}

// [QUANTITY_][AXIS_] in front of a fault's name.
bool read_where(std::string_view text, Fault& fault) {
    if (text.empty()) return true;
    if (text.back() != '_') return false;
    text.remove_suffix(1);
    const bool is_axis = text.size() == 1 || (text.size() > 1 && text[text.size() - 2] == '_');
    if (is_axis && text.back() >= 'x' && text.back() <= 'z') {
        fault.axis = text.back() - 'x';
        text.remove_suffix(text.size() == 1 ? 1 : 2);
    }
    return copy(text, fault.quantity);
}

std::optional<Fault> of_part(std::string_view part, std::string_view name, std::string_view value,
                             bool has_value) {
    for (const Row& row : kPartRows) {
        if (!name.ends_with(row.name)) continue;
        const auto number = value_of(row, value, has_value);
        Fault fault{.kind = row.kind};
        if (!number || part.empty() || !copy(part, fault.part)) return {};
        if (!read_where(name.substr(0, name.size() - row.name.size()), fault)) continue;
        fault.value = *number;
        return fault;
    }
    return {};
}

std::optional<Fault> of_motor(std::string_view name, std::string_view value, bool has_value) {
    const auto number = value_of(kMotorRow, value, has_value);
    Fault fault{.kind = kMotorRow.kind};
    const auto motor = read(name.substr(kMotorRow.name.size()), 1.0, kMaxRotors);
    if (!number || !motor || !copy(name, fault.part)) return {};
    fault.value = *number;
    return fault;
}

std::optional<Fault> of_name(std::string_view name, std::string_view value, bool has_value) {
    const std::size_t dot = name.find('.');
    if (dot != name.npos)
        return of_part(name.substr(0, dot), name.substr(dot + 1), value, has_value);
    if (name.starts_with(kMotorRow.name)) return of_motor(name, value, has_value);
    for (const Row& row : kRows) {
        if (row.name != name) continue;
        const auto number = value_of(row, value, has_value);
        if (!number) return {};
        return Fault{.kind = row.kind, .value = *number};
    }
    return {};
}

std::uint64_t microseconds(double seconds) {
    return math::saturate<std::uint64_t>(math::round(seconds * 1e6));
}

}  // namespace

const char* const kFaultNames =
    "gnss_loss, gnss_glitch[=METRES], baro_loss, mission_loss, rc_loss, battery_low[=0..1], "
    "motor_1 to motor_12[=0..1], or PART.FAULT[=VALUE] of a part of the graph";

bool Faults::add(const Fault& fault) {
    if (count_ == kMax) return false;
    faults_[count_++] = fault;
    return true;
}

std::optional<double> Faults::now(FaultKind kind, std::uint64_t time_us) const {
    std::optional<double> result;
    for (unsigned i = 0; i < count_; ++i) {
        const Fault& fault = faults_[i];
        if (fault.kind == kind && fault.acts(time_us)) result = fault.value;
    }
    return result;
}

std::optional<double> Faults::now(std::string_view part, FaultKind kind,
                                  std::uint64_t time_us) const {
    std::optional<double> result;
    for (const Fault& fault : *this) {
        if (fault.kind == kind && fault.is_of(part) && fault.acts(time_us)) result = fault.value;
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
    const auto from = read(when.substr(0, plus), 0.0, kLatest_s);
    const bool for_good = plus == std::string_view::npos;
    const auto lasts = for_good ? 2.0 * kLatest_s : read(when.substr(plus + 1), 0.0, kLatest_s);
    if (!fault || !from || !lasts) return {};
    fault->from_us = microseconds(*from);
    fault->until_us = microseconds(*from + *lasts);
    return fault;
}

}  // namespace stator::world
