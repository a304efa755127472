// A line of text in a fixed place, and numbers to and from text.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace stator::apps::shell {

// What finds no room is left out.
class Line {
  public:
    static constexpr std::size_t kRoom = 192;

    bool is_empty() const { return begin_ == end_; }
    std::size_t room() const { return kRoom - end_; }
    void clear() { begin_ = end_ = line_begin_ = 0; }

    Line& put(std::string_view text);
    Line& put(char c) { return put(std::string_view(&c, 1)); }
    Line& put_whole(int64_t value);
    // As `%.7g` would, with a sign only if it is negative.
    Line& put_real(double value);
    // Spaces up to this column of the line that began at the last clear or line end.
    Line& fill(std::size_t column);
    Line& end_line();

    // Moves characters out; says how many.
    std::size_t take(std::span<uint8_t> to);

  private:
    std::array<char, kRoom> text_{};
    std::size_t begin_ = 0;
    std::size_t end_ = 0;
    std::size_t line_begin_ = 0;
};

std::optional<int32_t> read_whole(std::string_view text);
// The nearest float; numbers of more than 17 digits are not read.
std::optional<float> read_real(std::string_view text);

// The next word of `line`, which then begins behind it; empty: there is none.
std::string_view next_word(std::string_view& line);

}  // namespace stator::apps::shell
