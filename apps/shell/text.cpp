// A line of text in a fixed place, and numbers to and from text.
#include "text.hpp"

#include "stator/math/bits.hpp"

namespace stator::apps::shell {

namespace {

constexpr int kDigits = 7;  // that a float is written with

// 10^exponent, exact up to 10^22.
double power_of_ten(int exponent) {
    double power = 1.0;
    for (int i = 0; i < exponent; ++i) power *= 10.0;
    return power;
}

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

}  // namespace

Line& Line::put(std::string_view text) {
    const std::size_t count = std::min(text.size(), room());
    std::copy_n(text.begin(), count, text_.begin() + static_cast<std::ptrdiff_t>(end_));
    end_ += count;
    return *this;
}

Line& Line::put_whole(int64_t value) {
    std::array<char, 20> digits{};
    std::size_t at = digits.size();
    uint64_t left = value < 0 ? ~static_cast<uint64_t>(value) + 1 : static_cast<uint64_t>(value);
    do {
        digits[--at] = static_cast<char>('0' + left % 10);
        left /= 10;
    } while (left != 0);
    if (value < 0) put('-');
    return put(std::string_view(digits.data() + at, digits.size() - at));
}

Line& Line::put_real(double value) {
    if (math::is_nan(value)) return put("nan");
    if (value < 0.0) {
        put('-');
        value = -value;
    }
    if (value == 0.0) return put('0');
    if (!math::is_finite(value)) return put("inf");
    int exponent = 0;  // of the first digit
    while (value >= 1e16) value /= 1e16, exponent += 16;
    while (value >= 10.0) value /= 10.0, ++exponent;
    while (value < 1e-16) value *= 1e16, exponent -= 16;
    while (value < 1.0) value *= 10.0, --exponent;
    auto digits = static_cast<int64_t>(value * power_of_ten(kDigits - 1) + 0.5);
    if (digits >= 10'000'000) digits /= 10, ++exponent;
    int count = kDigits;
    while (count > 1 && digits % 10 == 0) digits /= 10, --count;
    const bool is_scientific = exponent < -4 || exponent >= kDigits;
    std::array<char, kDigits> text{};
    for (int i = count - 1; i >= 0; --i) {
        text[static_cast<std::size_t>(i)] = static_cast<char>('0' + digits % 10);
        digits /= 10;
    }
    const int before = is_scientific ? 1 : exponent + 1;  // digits before the point
    if (before <= 0) put("0.");
    for (int i = before; i < 0; ++i) put('0');
    for (int i = 0; i < std::max(count, before); ++i) {
        if (i == before && before > 0) put('.');
        put(i < count ? text[static_cast<std::size_t>(i)] : '0');
    }
    return is_scientific ? put('e').put_whole(exponent) : *this;
}

Line& Line::fill(std::size_t column) {
    while (end_ - line_begin_ < column && room() != 0) put(' ');
    return *this;
}

Line& Line::end_line() {
    if (room() == 0) --end_;
    put('\n');
    line_begin_ = end_;
    return *this;
}

std::size_t Line::take(std::span<uint8_t> to) {
    const std::size_t count = std::min(to.size(), end_ - begin_);
    for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<uint8_t>(text_[begin_ + i]);
    begin_ += count;
    if (is_empty()) begin_ = end_ = line_begin_ = 0;
    return count;
}

std::optional<int32_t> read_whole(std::string_view text) {
    const bool is_negative = text.starts_with('-');
    if (is_negative) text.remove_prefix(1);
    if (text.empty() || text.size() > 10) return {};
    int64_t value = 0;
    for (const char c : text) {
        if (!is_digit(c)) return {};
        value = value * 10 + (c - '0');
    }
    if (is_negative) value = -value;
    if (value < INT32_MIN || value > INT32_MAX) return {};
    return static_cast<int32_t>(value);
}

std::optional<float> read_real(std::string_view text) {
    const bool is_negative = text.starts_with('-');
    if (is_negative) text.remove_prefix(1);
    int64_t digits = 0;
    int count = 0;
    int exponent = 0;
    bool has_point = false;
    while (!text.empty() && (is_digit(text.front()) || (text.front() == '.' && !has_point))) {
        const char c = text.front();
        text.remove_prefix(1);
        if (c == '.') {
            has_point = true;
            continue;
        }
        if (++count > 17) return {};
        digits = digits * 10 + (c - '0');
        if (has_point) --exponent;
    }
    if (count == 0) return {};
    if (text.starts_with('e') || text.starts_with('E')) {
        text.remove_prefix(text.starts_with("e+") || text.starts_with("E+") ? 2 : 1);
        const auto more = text.size() > 3 ? std::optional<int32_t>() : read_whole(text);
        if (!more) return {};
        exponent += *more;
        text = {};
    }
    if (!text.empty() || exponent < -60 || exponent > 38) return {};
    const auto value = static_cast<double>(digits);
    const double scaled =
        exponent < 0 ? value / power_of_ten(-exponent) : value * power_of_ten(exponent);
    const auto real = static_cast<float>(is_negative ? -scaled : scaled);
    if (!math::is_finite(real)) return {};
    return real;
}

std::string_view next_word(std::string_view& line) {
    while (line.starts_with(' ')) line.remove_prefix(1);
    const std::size_t end = std::min(line.find(' '), line.size());
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(end);
    return word;
}

}  // namespace stator::apps::shell
