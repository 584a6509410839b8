// Shared code of the shim's parts: error handling of a call, and lists of names.
#pragma once
#include <libsumo/libsumo.h>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

namespace sim = libsumo;
#define API extern "C" __attribute__((visibility("default")))

namespace shim {

inline thread_local std::string error_text;

// Runs `body` and returns 0, or 1 with a message in `error_text` after an exception; no exception leaves it.
template <class F>
int guard(F body) noexcept {
    try {
        body();
        return 0;
    } catch (const std::exception& e) {
        error_text = e.what();
    } catch (...) {
        error_text = "unknown C++ exception";
    }
    return 1;
}

inline std::vector<std::string> strings(const char* const* items, size_t n) { return {items, items + n}; }

}  // namespace shim
