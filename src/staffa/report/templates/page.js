"use strict";
// What moves on a page: curves, cracks in 3-D, the time slider, copying, and a page that grows.
// Without it the page shows the same as pictures and tables.
(() => {
  const root = document.documentElement;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const coarse = matchMedia("(pointer: coarse)").matches;
  const color = name => getComputedStyle(root).getPropertyValue(name).trim();
  const data = id => {
    const found = document.getElementById(id);
    return found ? JSON.parse(found.textContent) : null;
  };
  const made = (tag, parts) => Object.assign(document.createElement(tag), parts);
  root.classList.add("js");

  // Curves. Black lines of the pictures are white in the dark; others have a contrast of three.
  const BLACK = "#1a1a1a";
  const parts = hex => [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16));
  const full = hex => hex.length === 4 ? hex.replace(/[^#]/g, "$&$&") : hex;
  const light = hex => parts(hex).map(part => part / 255)
    .map(part => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4)
    .reduce((sum, part, which) => sum + [0.2126, 0.7152, 0.0722][which] * part, 0);
  const contrast = (one, other) => {
    const [low, high] = [light(one), light(other)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const mixed = (one, other, share) => "#" + parts(one)
    .map((part, at) => Math.round((1 - share) * part + share * parts(other)[at]))
    .map(part => part.toString(16).padStart(2, "0")).join("");
  // A line that lets the page through is drawn in the color that it then has.
  const visible = (given, opacity = 1, least = 3) => {
    const [back, ink] = [full(color("--back")), full(color("--ink"))];
    const seen = mixed(back, given === BLACK ? ink : given, opacity);
    const shares = [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1];
    return shares.map(share => mixed(seen, ink, share)).find(one => contrast(one, back) >= least);
  };
  const shade = (part, opacity, least) =>
    part && part.color ? {...part, color: visible(part.color, opacity, least)} : part;
  const translucent = (hex, opacity) => `rgba(${parts(hex).join(",")},${opacity})`;
  const band = trace => {
    const edge = visible(trace.fillcolor);
    return {...trace, opacity: 1, fillcolor: translucent(edge, trace.opacity),
      line: {...trace.line, color: edge, width: 1}};
  };
  const curve = trace => ({...trace, opacity: 1, line: shade(trace.line, trace.opacity),
    marker: shade(trace.marker, trace.opacity)});
  const themed = trace => trace.fill ? band(trace) : curve(trace);
  const axis = given => ({
    automargin: true, gridcolor: color("--line"), linecolor: color("--soft"), showline: true,
    zerolinecolor: color("--line"), ticks: "outside", tickcolor: color("--soft"), ...given,
    title: {standoff: 8, ...given.title},
  });
  const plain = () => ({
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: {color: color("--ink"), family: "system-ui, sans-serif", size: 13},
    hoverlabel: {bgcolor: color("--back"), bordercolor: color("--soft"),
      font: {color: color("--ink")}},
    margin: {l: 10, r: 10, t: 10, b: 10},
    modebar: {bgcolor: "rgba(0,0,0,0)", color: color("--soft"), activecolor: color("--ink")},
  });
  const flat = given => {
    const unit = given.unit;
    return {
      ...plain(), hovermode: given.hovermode, dragmode: coarse ? false : "zoom",
      xaxis: {...axis(given.xaxis), hoverformat: ".4~g",
        unifiedhovertitle: {text: `%{x:.4~g}${unit}`}},
      yaxis: axis(given.yaxis),
      shapes: given.shapes.map(shape => ({...shape, line: shade(shape.line)})),
      annotations: given.annotations.map(note => ({...note, font: shade(note.font, 1, 4.5)})),
      legend: {...given.legend, orientation: "h", x: 0, xanchor: "left", y: 1.02, yanchor: "bottom",
        bgcolor: "rgba(0,0,0,0)"},
      showlegend: true,
    };
  };
  // From farther away where the page is narrow, so that no number at an axis is cut.
  const farther = scene => {
    const far = innerWidth < 600 ? 1.25 : 1;
    const {x, y, z} = scene.camera.eye;
    return {...scene, camera: {...scene.camera, eye: {x: far * x, y: far * y, z: far * z}}};
  };
  // On white, as pictures are: the colors of cracks go down to nearly black.
  const solid = given => ({
    ...plain(), font: {color: BLACK, family: "system-ui, sans-serif", size: 13},
    paper_bgcolor: "#fff", margin: {l: 0, r: 0, t: 40, b: 0}, showlegend: false,
    title: {...given.title, x: 0.01, xanchor: "left", font: {size: 14}}, scene: farther(given.scene),
  });
  const config = {
    showSendToCloud: false, plotlyServerURL: "", // Plotly's own page, to which nothing is to go
    displaylogo: false, responsive: true, displayModeBar: "hover",
    modeBarButtonsToRemove: ["toImage", "lasso2d", "select2d"],
  };
  const draw = () => {
    for (const place of document.querySelectorAll("[data-chart]")) {
      const chart = data(place.dataset.chart);
      const layout = chart.layout.scene ? solid(chart.layout) : flat(chart.layout);
      Plotly.react(place, chart.layout.scene ? chart.data : chart.data.map(themed), layout, config);
    }
  };
  for (const figure of document.querySelectorAll("figure.live")) figure.classList.add("drawn");
  draw();
  dark.addEventListener("change", draw);

  // The time slider.
  const slides = data("slides");
  const slider = document.getElementById("time");
  const keep = (name, value) => { try { sessionStorage.setItem(name, value); } catch {} };
  const kept = name => { try { return sessionStorage.getItem(name); } catch { return null; } };
  if (slides && slider) {
    const last = slides.length - 1;
    const show = number => {
      const slide = slides[number];
      slider.value = number;
      slider.setAttribute("aria-valuetext", slide.label);
      document.getElementById("when").textContent = slide.label;
      for (const what of ["damage", "temperature"]) {
        document.getElementById(`slide-${what}`).src = slide[what];
      }
    };
    slider.max = last;
    slider.addEventListener("input", () => {
      show(Number(slider.value));
      keep("slide", slider.value === slider.max ? "" : slider.value);
    });
    const before = kept("slide");
    show(before && Number(before) <= last ? Number(before) : last);
    const play = document.getElementById("play");
    let timer = 0;
    const stop = () => { clearInterval(timer); timer = 0; play.textContent = "Play"; };
    play.addEventListener("click", () => {
      if (timer) return stop();
      if (Number(slider.value) === last) show(0);
      play.textContent = "Pause";
      timer = setInterval(() => {
        show(Math.min(Number(slider.value) + 1, last));
        if (Number(slider.value) === last) stop();
      }, 400);
    });
  }

  // What is wider than the screen fades at the side where more of it is, and says so.
  const look = (place, hint) => {
    const rest = place.scrollWidth - place.clientWidth;
    place.classList.toggle("before", place.scrollLeft > 1);
    place.classList.toggle("after", place.scrollLeft < rest - 1);
    hint.hidden = rest <= 1;
  };
  for (const place of document.querySelectorAll(".wide")) {
    const hint = made("p", {className: "hint", hidden: true});
    hint.textContent = coarse ? "wider than the screen: swipe ↔" : "wider than the page: scroll ↔";
    hint.setAttribute("aria-hidden", "true"); // the region itself is told, and takes the arrow keys
    place.after(hint);
    place.addEventListener("scroll", () => look(place, hint), {passive: true});
    const sizes = new ResizeObserver(() => look(place, hint));
    for (const one of [place, ...place.children]) sizes.observe(one);
  }

  // Tables, the case and commands to copy; a spreadsheet computes no text.
  const cell = found => {
    const text = found.textContent.trim();
    return /^([=+@]|-(?![\d.]))/.test(text) && text !== "-" ? `'${text}` : text;
  };
  const text = target => target.tagName !== "TABLE" ? target.textContent :
    [...target.rows].map(row => [...row.cells].map(cell).join("\t")).join("\n");
  const copy = async target => {
    try {
      await navigator.clipboard.writeText(text(target));
    } catch {
      const area = made("textarea", {value: text(target)});
      document.body.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
  };
  for (const target of document.querySelectorAll("table, pre")) {
    const button = made("button", {type: "button", className: "copy", textContent: "Copy"});
    const what = target.dataset.name;
    button.setAttribute("aria-label", `Copy ${what}`);
    button.addEventListener("click", async () => {
      await copy(target);
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy"; }, 2000);
    });
    target.parentElement.before(button);
  }

  // A page that grows is read again, unless the reader asks it to stay.
  const grows = document.getElementById("grows");
  if (grows) {
    const stay = made("button", {type: "button"});
    let timer = 0;
    const wait = staying => {
      clearTimeout(timer);
      keep("stay", staying ? "1" : "");
      stay.textContent = staying ? "Read it again from now on" : "Keep it as it is";
      stay.setAttribute("aria-pressed", String(staying));
      if (!staying) timer = setTimeout(() => location.reload(), 1000 * grows.dataset.seconds);
    };
    stay.addEventListener("click", () => wait(stay.getAttribute("aria-pressed") !== "true"));
    grows.append(" ", stay);
    wait(kept("stay") === "1");
  }
})();
