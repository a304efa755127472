// The file with the key of MAVLink's signatures.
#include "world/key_file.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace stator::world {

namespace {

bool refuse(const char* path, const char* why) {
    std::fprintf(stderr, "error: --signing-key '%s': %s\n", path, why);
    return false;
}

bool is_hexadecimal(std::string_view text, mav::SigningKeyBytes& bytes) {
    if (text.size() != 2 * bytes.size()) return false;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const char* const digits = text.data() + 2 * i;
        const auto [end, error] = std::from_chars(digits, digits + 2, bytes[i], 16);
        if (error != std::errc{} || end != digits + 2) return false;
    }
    return true;
}

mav::SigningKeyBytes hash_of(std::string_view phrase) {
    mav::Sha256 sha;
    for (const char c : phrase) {
        const auto byte = static_cast<std::uint8_t>(c);
        sha.add({&byte, 1});
    }
    return sha.finish();
}

}  // namespace

bool read_key(const char* path, mav::SharedKey& key) {
    std::FILE* const file = std::fopen(path, "rb");
    if (file == nullptr) return refuse(path, std::strerror(errno));
    std::array<char, 256> text{};
    const std::size_t size = std::fread(text.data(), 1, text.size(), file);
    std::fclose(file);
    const std::string_view all(text.data(), size);
    const std::string_view line = all.substr(0, all.find_first_of("\r\n"));
    if (line.empty() || line.size() == text.size()) {
        return refuse(path, "expected 64 hexadecimal digits, or a phrase of up to 255 characters");
    }
    mav::SigningKey given{.state = mav::SigningKey::State::kSet};
    if (!is_hexadecimal(line, given.bytes)) given.bytes = hash_of(line);
    if (given.bytes == mav::SigningKeyBytes{}) return refuse(path, "the key is blank");
    return key.write(given) || refuse(path, "the key is in use");
}

}  // namespace stator::world
