// The pilot of a simulated flight.
#include "world/pilot.hpp"

#include <charconv>
#include <string_view>

#include "stator/scalar.hpp"

namespace stator::world {

namespace {

constexpr std::uint64_t kArms_us = 1'000'000;
constexpr double kLatest_s = 1e6;

// Takes the next word off a line; empty at its end.
std::string_view take_word(std::string_view& line) {
    constexpr std::string_view kBlank = " \t\r";
    const std::size_t begin = line.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) return line = {};
    const std::size_t end = line.find_first_of(kBlank, begin);
    const std::string_view word = line.substr(begin, end == line.npos ? end : end - begin);
    line = end == line.npos ? std::string_view{} : line.substr(end);
    return word;
}

bool take(std::string_view& line, double least, double most, double& number) {
    const std::string_view word = take_word(line);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (word.empty() || error != std::errc{} || end != word.data() + word.size()) return false;
    return number >= least && number <= most;
}

bool take(std::string_view& line, float& stick) {
    double number = 0.0;
    if (!take(line, -1.0, 1.0, number)) return false;
    stick = static_cast<float>(number);
    return true;
}

bool take(std::string_view& line, unsigned most, unsigned& position) {
    double number = 0.0;
    if (!take(line, 0.0, static_cast<double>(most), number)) return false;
    position = static_cast<unsigned>(number);
    return static_cast<double>(position) == number;
}

bool take(std::string_view& line, bool& on) {
    unsigned position = 0;
    if (!take(line, 1, position)) return false;
    on = position == 1;
    return true;
}

bool read(std::string_view line, PilotFrame& frame) {
    double seconds = 0.0;
    if (!take(line, 0.0, kLatest_s, seconds)) return false;
    frame.time_us = math::saturate<std::uint64_t>(math::round(seconds * 1e6));
    return take(line, frame.roll) && take(line, frame.pitch) && take(line, frame.yaw) &&
           take(line, frame.throttle) && take(line, 6U, frame.mode_slot) && take(line, frame.arm) &&
           take(line, frame.return_home) && take(line, frame.kill) && take_word(line).empty();
}

// Takes the next line off a text.
std::string_view take_line(std::string_view& text) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text = end == text.npos ? std::string_view{} : text.substr(end + 1);
    return line;
}

}  // namespace

Pilot::Pilot() : frames_{PilotFrame{}, PilotFrame{.time_us = kArms_us, .arm = true}} {}

std::string Pilot::follow(std::string_view script) {
    std::vector<PilotFrame> frames{PilotFrame{}};
    std::string_view text = script;
    for (unsigned number = 1; !text.empty(); ++number) {
        std::string_view line = take_line(text);
        line = line.substr(0, line.find('#'));
        std::string_view rest = line;
        if (take_word(rest).empty()) continue;
        PilotFrame frame;
        if (!read(line, frame)) {
            return "line " + std::to_string(number) +
                   ": expected: seconds roll pitch yaw throttle (-1 to 1) mode_slot (0 to 6) arm "
                   "return kill (0 or 1)";
        }
        if (frame.time_us < frames.back().time_us) {
            return "line " + std::to_string(number) +
                   ": expected a time not before that of the line above";
        }
        frames.push_back(frame);
    }
    frames_ = frames;
    return {};
}

const PilotFrame& Pilot::frame(std::uint64_t time_us) const {
    std::size_t i = frames_.size() - 1;
    while (frames_[i].time_us > time_us) --i;
    return frames_[i];
}

}  // namespace stator::world
