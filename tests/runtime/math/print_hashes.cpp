// Prints the hashes of same_bits.cpp, one a line, in the form of expected_hashes.inc.
#include <cinttypes>
#include <cstdio>

#include "same_bits.hpp"

int main() {
    for (const auto& [name, hash] : stator::math::result_hashes()) {
        std::printf("{\"%s\", 0x%016" PRIx64 "},\n", name.c_str(), hash);
    }
}
