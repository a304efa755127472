// What one person has typed, and what is printed for that person.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "text.hpp"

namespace stator::apps::shell {

// Lines that come while a command runs wait, as far as there is room; what comes then is lost up to
// the end of its line, which is said.
class Console {
  public:
    static constexpr std::size_t kRoom = 160;

    // Forgets all that waits.
    void reset();
    // Ctrl-C forgets all that waits. True: it was typed.
    bool type(std::span<const uint8_t> text);
    // The next whole line, which stands until the next call of a member; none: it is not there yet.
    std::optional<std::string_view> next_line();
    bool has_line() const;
    bool has_lost_line() const { return is_lost_; }
    void forget_loss() { is_lost_ = false; }

    Line out;

  private:
    bool type(uint8_t c);
    void put(char c);

    std::array<char, kRoom> typed_{};
    std::size_t count_ = 0;
    std::size_t taken_ = 0;  // of the line that was handed out
    bool is_skipping_ = false;
    bool is_lost_ = false;
    bool was_return_ = false;
};

}  // namespace stator::apps::shell
