// Films far from what is read are unloaded: a browser draws only so many at once.
document.addEventListener("DOMContentLoaded", () => {
  const watch = new IntersectionObserver(seen => {
    for (const { target, isIntersecting } of seen) {
      if (isIntersecting && !target.src) target.src = target.dataset.film;
      if (!isIntersecting && target.src) target.removeAttribute("src");
    }
  }, { rootMargin: "400px" });
  for (const film of document.querySelectorAll("figure.film iframe")) {
    film.dataset.film = film.src;
    watch.observe(film);
  }
});
