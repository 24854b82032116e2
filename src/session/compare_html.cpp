// The report of `compare --html`: one page with its pictures beside it, no other files and no network.
#include "base/error.h"
#include "session/compare.h"

namespace parhelion::detail {

namespace {

constexpr const char* kStyle =
    "body{font:14px/1.4 sans-serif;margin:2em;background:#222;color:#ddd}table{border-collapse:collapse;margin:1em 0}"
    "td,th{padding:.2em .8em;text-align:right;border-bottom:1px solid #444}th{color:#aaa;font-weight:normal}"
    "figure{display:inline-block;margin:0 1em 1em 0}img{display:block;max-width:30vw;min-width:256px;image-rendering:pixelated}"
    ".swap{position:relative}.swap img+img{position:absolute;inset:0;opacity:0}.swap:hover img+img{opacity:1}.over{color:#f66}";

std::string picture(const ComparedFrame& frame, std::string_view kind) {
    const std::string file = frame.name.empty() ? fmt::format("{}.png", kind) : fmt::format("{}.{}.png", kind, frame.name);
    return fmt::format("<img src=\"{}\" alt=\"{}\">", html_text(file), kind);
}

std::string row(const ComparedFrame& frame) {
    const image::Comparison& c = frame.result;
    return fmt::format(
        "<tr><td>{}</td><td>{:.6g}</td><td>{:.6g}</td><td>{:.6g}</td><td>{:.2f}</td><td>{:.5f}</td><td>{:.5f}</td><td>{}</td></tr>\n",
        html_text(frame.name), c.mean_ratio.luminance, c.mse, c.relmse, c.psnr, c.ssim, c.flip.mean, c.bad.nan + c.bad.infinite);
}

std::string figures(const ComparedFrame& frame) {
    std::string out = frame.name.empty() ? "" : fmt::format("<h2>frame {}</h2>\n", html_text(frame.name));
    out += fmt::format("<figure><div class=\"swap\">{}{}</div><figcaption>test (reference under the pointer)</figcaption></figure>\n",
                       picture(frame, "test"), picture(frame, "reference"));
    out += fmt::format("<figure>{}<figcaption>reference</figcaption></figure>\n", picture(frame, "reference"));
    return out + fmt::format("<figure>{}<figcaption>FLIP {:.5f}: black equal, yellow different</figcaption></figure>\n",
                             picture(frame, "flip"), frame.result.flip.mean);
}

}  // namespace

std::string html_text(std::string_view text) {
    std::string out;
    for (const char c : escape_name(text)) switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    return out;
}

std::string html_page(const CompareReport& report) {
    std::string out = fmt::format(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Comparison</title><style>{}</style></head><body>\n",
        kStyle);
    out += fmt::format("<h1>{} against {}</h1>\n", html_text(report.test), html_text(report.reference));
    for (const std::string& line : report.exceeded) out += fmt::format("<p class=\"over\">{}</p>\n", html_text(line));
    out +=
        "<table><tr><th></th><th>mean ratio</th><th>MSE</th><th>relMSE</th><th>PSNR dB</th><th>SSIM</th><th>FLIP</th><th>broken "
        "pixels</th></tr>\n";
    for (const ComparedFrame& frame : report.frames) out += row(frame);
    out += "</table>\n";
    for (const ComparedFrame& frame : report.frames) out += figures(frame);
    return out + "</body></html>\n";
}

}  // namespace parhelion::detail
