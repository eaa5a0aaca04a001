// Asks for news of the watched file and puts them into the page; the report is loaded anew only when there is one.
(async () => {
  "use strict";
  const status = document.getElementById("watch");
  const frame = document.getElementById("report");
  const gone = document.getElementById("gone");
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const fit = () => {
    const inner = frame.contentDocument && frame.contentDocument.documentElement;
    if (inner) frame.style.height = `${inner.getBoundingClientRect().height}px`;
  };
  frame.addEventListener("load", () => {
    fit();
    const inner = frame.contentDocument && frame.contentDocument.documentElement;
    if (inner) new ResizeObserver(fit).observe(inner);
  });
  // What the reader opened or closed stays so.
  const chosen = new Map();
  status.addEventListener("click", (event) => {
    const details = event.target.closest("summary") && event.target.closest("details");
    if (details) chosen.set(details.id, !details.open);
  });
  let version = 0;
  let report = 0;
  for (;;) {
    try {
      const answer = await fetch(`state?since=${version}`, { cache: "no-store" });
      if (!answer.ok) throw new Error(String(answer.status));
      const news = await answer.json();
      gone.hidden = true;
      if (news.version !== version) {
        version = news.version;
        status.innerHTML = news.html;
        for (const details of status.querySelectorAll("details")) {
          if (chosen.has(details.id)) details.open = chosen.get(details.id);
        }
        document.title = news.title;
        if (news.report !== report) {
          report = news.report;
          frame.hidden = !report;
          if (report) frame.src = `report?v=${report}`;
        }
      }
      await wait(200);
    } catch (_) {
      gone.hidden = false;
      version = 0;
      report = -1;
      await wait(1000);
    }
  }
})();
