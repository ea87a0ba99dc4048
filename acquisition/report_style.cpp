// SPDX-License-Identifier: Apache-2.0
#include "acquisition/report_style.hpp"

namespace cmm::acquisition {

std::string_view report_style() {
    return R"css(
:root{color-scheme:light dark;--page:#f4f5f7;--paper:#fff;--ink:#1c2127;--soft:#5d6874;--rule:#dfe3e8;
--good:#1d7d4d;--out:#c22f26;--open:#a06400;--plain:#42505e;--good-soft:#1d7d4d14;--out-soft:#c22f2612;--open-soft:#a0640014}
@media (prefers-color-scheme:dark){:root{--page:#0e1114;--paper:#15191e;--ink:#e4e8ec;--soft:#98a3af;--rule:#2e353d;
--good:#55c08a;--out:#ff7b70;--open:#e0a63f;--plain:#aab6c2;--good-soft:#55c08a1a;--out-soft:#ff7b701a;--open-soft:#e0a63f1a}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif;
font-variant-numeric:tabular-nums;-webkit-text-size-adjust:100%}
main{max-width:1180px;margin:0 auto;padding:32px 20px 56px}
h1,h2,h3{margin:0;line-height:1.25;font-weight:600}
h1{font-size:28px;letter-spacing:-.01em}
h2{font-size:19px;margin:44px 0 12px}
h3{font-size:17px}
p{margin:0 0 8px;max-width:78ch}
.kind{color:var(--soft);font-size:13px;margin:0 0 2px}
.sheet{background:var(--paper);border:1px solid var(--rule);border-radius:6px;padding:20px 22px}
.head{display:grid;grid-template-columns:minmax(0,1fr) auto;gap:18px 28px;align-items:start}
.verdict{padding:12px 20px;border-radius:6px;min-width:190px;text-align:right;border:1px solid currentColor}
.verdict b{display:block;font-size:26px;line-height:1.2;letter-spacing:.01em}
.verdict span{font-size:13px}
.accept{color:var(--good)}.reject{color:var(--out)}.undecided{color:var(--open)}.reported,.done{color:var(--plain)}.not_evaluable{color:var(--soft)}
.verdict.accept{background:var(--good-soft)}.verdict.reject{background:var(--out-soft)}.verdict.undecided{background:var(--open-soft)}
.facts{display:grid;grid-template-columns:repeat(auto-fill,minmax(200px,1fr));gap:14px 24px;margin:22px 0 0;padding:18px 0 0;border-top:1px solid var(--rule)}
.facts div{min-width:0}
dt{color:var(--soft);font-size:12.5px}
dd{margin:0;overflow-wrap:anywhere}
.causes{margin:20px 0 0;padding:14px 0 0;border-top:1px solid var(--rule)}
.causes ul{margin:6px 0 0;padding-left:20px;columns:2;column-gap:40px;font-size:14px}
.causes li{margin:2px 0}
.wide{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:13.5px}
th,td{padding:7px 8px;text-align:right;white-space:nowrap;border-bottom:1px solid var(--rule);vertical-align:top}
tr:last-child td{border-bottom:0}
thead th{font-weight:600;font-size:12.5px;color:var(--soft);vertical-align:bottom}
thead th{white-space:normal}thead th small{white-space:nowrap;display:block;font-weight:400}
td small{display:block;color:var(--soft);font-size:12px}
td:first-child,th:first-child{padding-left:0}
td:last-child,th:last-child{padding-right:0}
th.word,td.word{text-align:left}
td.reject,td.undecided,td b{font-weight:600}
td a{color:inherit;text-decoration-color:var(--rule);text-underline-offset:3px}
td a:hover{text-decoration-color:currentColor}
.trends{display:grid;grid-template-columns:repeat(auto-fill,minmax(250px,1fr));gap:22px 20px}
figure{margin:0;min-width:0}
figcaption{font-size:12.5px;color:var(--soft);margin:0 0 6px}
figcaption b{color:var(--ink);font-weight:600}
.fig{display:block;width:100%;height:auto}
.section{margin-top:16px;break-inside:avoid}
.section header{display:flex;flex-wrap:wrap;gap:4px 18px;align-items:baseline;margin-bottom:16px}
.section header .state{font-weight:600;margin-left:auto}
.section header .meta{color:var(--soft);font-size:13.5px}
.plots{display:grid;grid-template-columns:repeat(4,minmax(0,1fr));gap:22px 16px;align-items:start}
.plots .half{grid-column:span 2}
details{margin-top:16px;border-top:1px solid var(--rule);padding-top:12px;font-size:13.5px}
summary{cursor:pointer;color:var(--soft)}
details table{margin-top:8px;width:auto;min-width:min(100%,620px)}
.key{display:flex;flex-wrap:wrap;gap:6px 22px;font-size:12.5px;color:var(--soft);margin:0 0 4px}
.key svg{width:26px;height:10px;display:inline-block;vertical-align:0;margin-right:7px;background:none}
.methods td,.methods th{white-space:normal;text-align:left}
.methods td:first-child{white-space:nowrap}
footer{margin-top:34px;color:var(--soft);font-size:12.5px}
@media (max-width:760px){.causes ul{columns:1}main{padding:18px 12px 40px}.sheet{padding:16px 14px}.head{grid-template-columns:minmax(0,1fr)}
.verdict{text-align:left}.plots{grid-template-columns:repeat(2,minmax(0,1fr))}
h1{font-size:24px}.section header .state{margin-left:0}}
@media (max-width:480px){.plots .quarter{grid-column:span 2}.plots .half{overflow-x:auto}.plots .half .fig{width:520px}}
@media print{:root,.fig{color-scheme:light;--page:#fff;--paper:#fff;--ink:#111;--soft:#4c5661;--rule:#cfd5db;--good:#1d7d4d;--out:#c22f26;
--open:#a06400;--plain:#42505e;--nominal:#8a95a1;--side:#1f66ad;--edge:#7a4fa3}body{font-size:11px}main{padding:0;max-width:none}.sheet{border:0;padding:0}h2{margin-top:24px}}
)css";
}

}  // namespace cmm::acquisition
