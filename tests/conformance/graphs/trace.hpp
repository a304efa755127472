// What the nodes saw, as text: one line where an activation begins, one where it ends. The board
// writes the lines where its machine can.
#pragma once

#include <cstdint>

#include "messages/ping.hpp"
#include "stator/port.hpp"

namespace stator::trace {

// Steps of a scenario: everything happens at a multiple of it, and is over before the next.
inline constexpr uint64_t kStep_us = 20'000;
inline constexpr uint64_t kEnd_us = 23 * kStep_us + kStep_us / 2;

// Of the board. `line` ends in a newline; `now_us` is of the activation that writes it.
void write(const char* line, uint64_t now_us);

// One line: "40 +#7 2 t1 a=#3.5*-2 b=#3.1,#3.2"; README.md says what that means.
class Line {
  public:
    Line(uint64_t now_us, const char* what, int32_t id) : now_us_(now_us) {
        number(now_us / 1000);
        text(what);
        number(static_cast<uint32_t>(id));
    }
    Line& text(const char* word) {
        while (*word != '\0' && length_ < kMost) text_[length_++] = *word++;
        return *this;
    }
    Line& number(uint64_t value) {
        char digits[20];
        unsigned count = 0;
        do {
            digits[count++] = static_cast<char>('0' + value % 10);
            value /= 10;
        } while (value != 0);
        while (count != 0 && length_ < kMost) text_[length_++] = digits[--count];
        return *this;
    }
    Line& ping(const Input<Ping>& input) {
        return text("#").number(input->source).text(".").number(input->value);
    }
    Line& lost(uint32_t count) { return count == 0 ? *this : text("-").number(count); }
    // A sample that is read once: * marks a new one, -2 that two passed unread before it.
    Line& sample(const char* name, const Input<Ping>& input) {
        if (!input) return *this;
        text(name).ping(input).text(input.is_new() ? "*" : "");
        return lost(input.lost());
    }
    Line& queue(const char* name, Input<Ping>& input) {
        const char* before = name;
        while (input.next()) {
            text(before).ping(input);
            before = ",";
        }
        return lost(input.lost());
    }
    void write() {
        text_[length_] = '\n';
        trace::write(text_, now_us_);
    }

  private:
    static constexpr unsigned kMost = 126;

    char text_[kMost + 2] = {};
    unsigned length_ = 0;
    uint64_t now_us_;
};

}  // namespace stator::trace
