// What one person has typed.
#include "console.hpp"

#include <algorithm>

namespace stator::apps::shell {

namespace {

constexpr uint8_t kInterrupt = 3;  // Ctrl-C
constexpr uint8_t kBackspace = 8;
constexpr uint8_t kDelete = 127;

}  // namespace

void Console::reset() {
    out.clear();
    count_ = taken_ = 0;
    is_skipping_ = is_lost_ = was_return_ = false;
}

bool Console::type(std::span<const uint8_t> text) {
    bool is_interrupted = false;
    for (const uint8_t c : text) is_interrupted |= type(c);
    return is_interrupted;
}

bool Console::type(uint8_t c) {
    const bool ends_return = was_return_ && c == '\n';
    was_return_ = c == '\r';
    if (ends_return) return false;
    switch (c) {
        case kInterrupt:
            reset();
            return true;
        case kBackspace:
        case kDelete:
            if (count_ > taken_ && typed_[count_ - 1] != '\n') --count_;
            return false;
        case '\r':
        case '\n':
            if (is_skipping_) {
                is_skipping_ = false;
                is_lost_ = true;
            } else {
                put('\n');
            }
            return false;
        case '\t':
            put(' ');
            return false;
        default:
            if (c >= ' ') put(c < kDelete ? static_cast<char>(c) : '?');
            return false;
    }
}

void Console::put(char c) {
    if (is_skipping_) return;
    if (count_ < kRoom) {
        typed_[count_++] = c;
        return;
    }
    if (c == '\n') {
        is_lost_ = true;
    } else {
        is_skipping_ = true;
    }
    while (count_ > taken_ && typed_[count_ - 1] != '\n') --count_;
}

bool Console::has_line() const {
    const auto begin = typed_.begin() + static_cast<std::ptrdiff_t>(taken_);
    const auto end = typed_.begin() + static_cast<std::ptrdiff_t>(count_);
    return std::find(begin, end, '\n') != end;
}

std::optional<std::string_view> Console::next_line() {
    std::copy(typed_.begin() + static_cast<std::ptrdiff_t>(taken_),
              typed_.begin() + static_cast<std::ptrdiff_t>(count_), typed_.begin());
    count_ -= taken_;
    taken_ = 0;
    if (!has_line()) return {};
    const auto end = std::find(typed_.begin(), typed_.end(), '\n');
    const auto length = static_cast<std::size_t>(end - typed_.begin());
    taken_ = length + 1;
    return std::string_view(typed_.data(), length);
}

}  // namespace stator::apps::shell
