// Sorts the table by the column whose head is pressed, at the second press the other way round. What has no value comes last.
const body = document.querySelector('tbody');
const heads = [...document.querySelectorAll('thead th')];

function sortBy(column, direction) {
  const value = (row) => {
    const { value: number } = row.cells[column].dataset;
    return column === 0 ? row.cells[0].textContent.trim() : number === undefined ? NaN : Number(number);
  };
  const rows = [...body.rows].sort((a, b) => {
    const [x, y] = [value(a), value(b)];
    if (column === 0) return direction * x.localeCompare(y, 'en', { numeric: true });
    return Number.isNaN(x) - Number.isNaN(y) || direction * (x - y);
  });
  body.append(...rows);
  heads.forEach((head, i) => { head.ariaSort = i !== column ? null : direction > 0 ? 'ascending' : 'descending'; });
}

heads.forEach((head, column) => {
  head.querySelector('button').addEventListener('click', () => sortBy(column, head.ariaSort === 'ascending' ? -1 : 1));
});
