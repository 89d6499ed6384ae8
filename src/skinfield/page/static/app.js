(()=>{function X(i){let t=document.getElementById(i);if(!t)throw new Error(`index.html has no #${i}`);return t}function qt(i,{text:t,...e}={},...n){let s=document.createElement(i);for(let[r,o]of Object.entries(e))o!=null&&o!==!1&&s.setAttribute(r,o===!0?"":o);return t!=null&&(s.textContent=t),s.append(...n.filter(r=>r!=null)),s}function le(i,t){i.textContent!==t&&(i.textContent=t)}function Rs(i,t){let e=JSON.stringify(t);if(i.dataset.options===e)return;i.dataset.options=e;let n=i.value,s=[];for(let[r,o,a]of t){let l=qt("option",{value:r,text:o});a?s.at(-1)?.label===a?s.at(-1).append(l):s.push(qt("optgroup",{label:a},l)):s.push(l)}i.replaceChildren(...s),t.some(([r])=>String(r)===n)&&(i.value=n)}function Uo(i,t,e){return Math.min(Math.max(i,t),e)}function sp(i,t){let e=null,n=null,s=()=>{if(e=null,!n)return;let r=n;n=null,e=setTimeout(s,t),i(...r)};return(...r)=>{n=r,e===null&&s()}}function ka(i){try{return localStorage.getItem(`skinfield.${i}`)}catch{return null}}function za(i,t){try{t===null?localStorage.removeItem(`skinfield.${i}`):localStorage.setItem(`skinfield.${i}`,t)}catch{}}function Va(){return matchMedia("(pointer: coarse)").matches}var M_=100;function w_(i,t,e){return Math.max(Number.isFinite(i.seen_s)?1e3*i.seen_s+t:1/0,e)}function rp(i,t){return Math.min(Math.max(i/(500*t)-1,0),1)}function op(i){if(!Number.isFinite(i))return"not of now";let t=i/1e3;return`last seen ${t<10?t.toFixed(1):Math.round(t)} s ago`}var Ha=class{#t=null;#i=0;#n=0;#e=new Map;#s=!0;#a;#r;#o;constructor({rows:t,scene:e,unread:n}){this.#a=t,this.#r=e,this.#o=n,setInterval(()=>this.look(),M_)}passes(t){this.#s=t,this.#t=null,this.#e.clear(),this.look()}update(t,e=performance.now()){let n={...t,contacts:t.contacts.map(r=>({...r}))};this.#t=n,this.#i=e,this.#n=1/0;let s=new Map;for(let{key:r,seen_ms:o}of n.contacts){let a=this.#e.get(r);s.set(r,a?.stamp===o?a:{stamp:o,at:e})}return this.#e=s,this.#h(e),n}drawn(t=performance.now()){this.#n=t}#h(t){let e=this.#t,n=this.#s?t-this.#i:0,s=!1;for(let r of e.contacts){let o=this.#s?t-this.#e.get(r.key).at:0,a=w_(r,n,o),l=r.old||this.#s&&a>1e3*r.fades_s;s||=l&&(!r.old||op(a)!==r.seen),Object.assign(r,{age_ms:a,old:l,seen:op(a)}),r.fade=l?1:this.#s?rp(a,r.fades_s):0}return s}look(t=performance.now()){let e=this.#t;if(!e)return this.#c(0);this.#h(t)&&this.#r.redraw();let n=new Map(e.contacts.map(c=>[c.key,c]));for(let c of this.#a())E_(c,n.get(c.dataset.key));this.#u();let s=this.#s&&e.stamp_ns>0,r=Math.max(t-this.#n,0),o=s?1e3*e.age_s+r:0,a=e.fades_s??.5,l=e.old&&(e.stamp_ns>0||e.contacts.length>0);this.#c(l?1:rp(o,a)),this.#o({unread_s:o/1e3,fades_s:a})}#u(){let e=this.#t.contacts.filter(({fade:n})=>n>0).sort((n,s)=>s.age_ms-n.age_ms)[0];le(X("contacts-seen"),e?e.seen:"")}#c(t){let{container:e}=this.#r,n=t>0?t.toFixed(2):"";(e.dataset.fade??"")!==n&&(e.dataset.fade=n,e.style.setProperty("--fade",n||"0"))}};function E_(i,t){if(!t)return;let{age_ms:e,fade:n,old:s}=t;i.dataset.ageMs=Number.isFinite(e)?String(Math.round(e)):"",i.classList.toggle("old",!!s),i.style.setProperty("--fade",n.toFixed(2)),i.title=n>0?t.seen:""}var Wi=class{#t=new Map;#i;#n;constructor(t,e=2e3){this.#i=t,this.#n=e}has(t){return this.#t.has(t)}async wait(t,e){let n={answered:!1};this.#t.set(t,n);let s=await e;return n.answered=!0,s?this.#t.get(t)===n&&setTimeout(()=>this.#e(t,n),this.#n):this.#e(t,n),s}settled(){for(let[t,{answered:e}]of this.#t)e&&this.#t.delete(t)}#e(t,e){this.#t.get(t)===e&&(this.#t.delete(t),this.#i(t))}};var T_={Pa:[[1e6,"MPa"],[1e3,"kPa"],[1,"Pa"]],m:[[.001,"mm"]],N:[[1,"N"],[.001,"mN"]],relative:[[1e3,"relative"]],1:[[1,"ΔC/C₀"]]};function lu(i,t){let e=T_[t]??[[1,t??""]],n=Math.abs(i),[s,r]=e.find(([o])=>n>=.9999*o)??e.at(-1);return{label:r,factor:s}}function Cs(i,t=3){if(!Number.isFinite(i))return"–";if(i===0)return"0";let e=t-1-Math.floor(Math.log10(Math.abs(i)));return uu(i.toFixed(Math.min(Math.max(e,0),8)))}function Gt(i,t=1){if(!Number.isFinite(i))return"–";let e=i.toFixed(t);return uu(Number(e)===0?e.replace("-",""):e)}function tr(i){return i?"rel.":"N"}function Fo({force:i,force_std:t}){return`${Gt(i,2)}${Number.isFinite(t)?` ± ${Gt(t,2)}`:""}`}function cu({size:i,std:t,angle:e}){return`${Fo({force:i,force_std:t})} along the skin, ${Gt(180*e/Math.PI,0)}° from x`}function ap(i,t,e=3){if(!Number.isFinite(i))return"–";let{label:n,factor:s}=lu(i,t);return`${Cs(i/s,e)}${n?` ${n}`:""}`}function er(i){return Number.isFinite(i)?i<999.5?`${Gt(i,0)} µs`:i<999500?`${Cs(i/1e3)} ms`:`${Cs(i/1e6)} s`:"–"}function Ps(i){if(!Number.isFinite(i))return"–";let t=Math.floor(Math.abs(i)*10+1e-6),e=String(Math.floor(t/10)%60).padStart(2,"0"),n=`${Math.floor(t/600)}:${e}.${t%10}`;return i<0&&t?uu(`-${n}`):n}function Ga(i){if(!Number.isFinite(i))return"–";let t=[[1e9,"GB"],[1e6,"MB"],[1e3,"kB"],[1,"B"]],[e,n]=t.find(([s])=>i>=.9995*s)??t.at(-1);return`${Cs(i/e)} ${n}`}function hu(i){return Number.isFinite(i)?String(Math.round(i)).replace(/\B(?=(\d{3})+$)/g," "):"–"}function Wa(i,t,e=5){let n=t-i;if(!(n>0)||!Number.isFinite(n))return[];let s=n/Math.max(e,1),r=10**Math.floor(Math.log10(s)),o=[1,2,2.5,5,10].map(c=>c*r).find(c=>c>=s*.999),a=Math.ceil(i/o-1e-6),l=Math.floor(t/o+1e-6);return Array.from({length:l-a+1},(c,h)=>(a+h)*o)}function Xa(i){if(!(i>0))return 0;for(let t=0;t<8;t+=1){let e=i*10**t;if(Math.abs(e-Math.round(e))<1e-6*e)return t}return 8}var A_={contacts:"contacts explain the reading",field:"of a field",linear:"of a linear answer"};function Or(i){return i?i>1?"two":"one":""}function lp({shape:i,radius:t,maybe:e,answer:n,readings:s,shear:r}){let o=Number.isFinite(t)?`, radius ${Gt(1e3*t,1)} mm`:"";return[i&&i!=="other"?`${i}${o}`:"",e?`${Or(e)} in the place of ${e>1?"this one":"two"} would explain the readings nearly as well`:"",r?cu(r):"",A_[n]??"",s>1?`mean of ${s} readings`:""].filter(Boolean).join("; ")}function uu(i){return i.replace("-","−")}var R_=[1,2,5,10],C_=3;function fu(i){if(!(i>0)||!Number.isFinite(i))return 0;let t=10**Math.floor(Math.log10(i));return R_.map(e=>e*t).find(e=>e>=i*(1-1e-9))}var qa=class{#t=0;#i=0;#n=0;#e=null;#s=1;reset(t=1){this.#s=t,this.#t=this.#i=this.#n=0,this.#e=null}follow([t,e],n){return Number.isFinite(t)&&Number.isFinite(e)&&this.#a(t,Math.max(e,0),n),this.value}get value(){return this.#t>this.#i?[this.#i,this.#t]:[0,this.#s]}#a(t,e,n){t<this.#i&&(this.#i=-fu(-t));let s=fu(e);if(s>=this.#t){this.#t=s,this.#e=null;return}(this.#e===null||n<this.#e)&&(this.#e=n,this.#n=0),this.#n=Math.max(this.#n,e),!(n-this.#e<C_)&&(this.#t=fu(this.#n)||this.#t,this.#e=null)}};var $a={viridis:"44015444025645045745055946075a46085c460a5d460b5e470d60470e6147106347116447136548146748166848176948186a481a6c481b6d481c6e481d6f481f70482071482173482374482475482576482677482878482979472a7a472c7a472d7b472e7c472f7d46307e46327e46337f463480453581453781453882443983443a83443b84433d84433e85423f854240864241864142874144874045884046883f47883f48893e49893e4a893e4c8a3d4d8a3d4e8a3c4f8a3c508b3b518b3b528b3a538b3a548c39558c39568c38588c38598c375a8c375b8d365c8d365d8d355e8d355f8d34608d34618d33628d33638d32648e32658e31668e31678e31688e30698e306a8e2f6b8e2f6c8e2e6d8e2e6e8e2e6f8e2d708e2d718e2c718e2c728e2c738e2b748e2b758e2a768e2a778e2a788e29798e297a8e297b8e287c8e287d8e277e8e277f8e27808e26818e26828e26828e25838e25848e25858e24868e24878e23888e23898e238a8d228b8d228c8d228d8d218e8d218f8d21908d21918c20928c20928c20938c1f948c1f958b1f968b1f978b1f988b1f998a1f9a8a1e9b8a1e9c891e9d891f9e891f9f881fa0881fa1881fa1871fa28720a38620a48621a58521a68522a78522a88423a98324aa8325ab8225ac8226ad8127ad8128ae8029af7f2ab07f2cb17e2db27d2eb37c2fb47c31b57b32b67a34b67935b77937b87838b9773aba763bbb753dbc743fbc7340bd7242be7144bf7046c06f48c16e4ac16d4cc26c4ec36b50c46a52c56954c56856c66758c7655ac8645cc8635ec96260ca6063cb5f65cb5e67cc5c69cd5b6ccd5a6ece5870cf5773d05675d05477d1537ad1517cd2507fd34e81d34d84d44b86d54989d5488bd6468ed64590d74393d74195d84098d83e9bd93c9dd93ba0da39a2da37a5db36a8db34aadc32addc30b0dd2fb2dd2db5de2bb8de29bade28bddf26c0df25c2df23c5e021c8e020cae11fcde11dd0e11cd2e21bd5e21ad8e219dae319dde318dfe318e2e418e5e419e7e419eae51aece51befe51cf1e51df4e61ef6e620f8e621fbe723fde725",cividis:"00224e00234f00245100255300255400265600275800285900285b00295d002a5f002a61002b62002c64002c66002d68002e6a002e6c002f6d00306f0030700031700031710132710533710833700c34700f357012357014367016377018376f1a386f1c396f1e3a6f203a6f213b6e233c6e243c6e263d6e273e6e293f6e2a3f6d2b406d2d416d2e416d2f426d31436d32436d33446d34456c35456c36466c38476c39486c3a486c3b496c3c4a6c3d4a6c3e4b6c3f4c6c404c6c414d6c424e6c434e6c444f6c45506c46516c47516c48526c49536c4a536c4b546c4c556c4d556c4e566c4f576c50576c51586d52596d535a6d545a6d555b6d555c6d565c6d575d6d585e6d595e6e5a5f6e5b606e5c616e5d616e5e626e5e636f5f636f60646f61656f62656f636670646770656870656870666970676a71686a71696b716a6c716b6d726c6d726c6e726d6f726e6f736f70737071737172747272747273747374757474757575757676767777767777777878777979777a7a787b7a787c7b787d7c787e7c787e7d787f7e78807f78817f788280798381798482798582798683798784788885788985788a86788b87788c88788d88788e89788f8a78908b78918b78928c78928d78938e78948e77958f779690779791779892779992779a93769b94769c95769d95769e96769f9775a09875a19975a29975a39a74a49b74a59c74a69c74a79d73a89e73a99f73aaa073aba072aca172ada272aea371afa471b0a571b1a570b3a670b4a76fb5a86fb6a96fb7a96eb8aa6eb9ab6dbaac6dbbad6dbcae6cbdae6cbeaf6bbfb06bc0b16ac1b26ac2b369c3b369c4b468c5b568c6b667c7b767c8b866c9b965cbb965ccba64cdbb63cebc63cfbd62d0be62d1bf61d2c060d3c05fd4c15fd5c25ed6c35dd7c45cd9c55cdac65bdbc75adcc859ddc858dec958dfca57e0cb56e1cc55e2cd54e4ce53e5cf52e6d051e7d150e8d24fe9d34eead34cebd44bedd54aeed649efd748f0d846f1d945f2da44f3db42f5dc41f6dd3ff7de3ef8df3cf9e03afbe138fce236fde334fee434fee535fee636fee838",plasma:"0d088710078813078916078a19068c1b068d1d068e20068f2206902406912605912805922a05932c05942e05952f059631059733059735049837049938049a3a049a3c049b3e049c3f049c41049d43039e44039e46039f48039f4903a04b03a14c02a14e02a25002a25102a35302a35502a45601a45801a45901a55b01a55c01a65e01a66001a66100a76300a76400a76600a76700a86900a86a00a86c00a86e00a86f00a87100a87201a87401a87501a87701a87801a87a02a87b02a87d03a87e03a88004a88104a78305a78405a78606a68707a68808a68a09a58b0aa58d0ba58e0ca48f0da4910ea3920fa39410a29511a19613a19814a099159f9a169f9c179e9d189d9e199da01a9ca11b9ba21d9aa31e9aa51f99a62098a72197a82296aa2395ab2494ac2694ad2793ae2892b02991b12a90b22b8fb32c8eb42e8db52f8cb6308bb7318ab83289ba3388bb3488bc3587bd3786be3885bf3984c03a83c13b82c23c81c33d80c43e7fc5407ec6417dc7427cc8437bc9447aca457acb4679cc4778cc4977cd4a76ce4b75cf4c74d04d73d14e72d24f71d35171d45270d5536fd5546ed6556dd7566cd8576bd9586ada5a6ada5b69db5c68dc5d67dd5e66de5f65de6164df6263e06363e16462e26561e26660e3685fe4695ee56a5de56b5de66c5ce76e5be76f5ae87059e97158e97257ea7457eb7556eb7655ec7754ed7953ed7a52ee7b51ef7c51ef7e50f07f4ff0804ef1814df1834cf2844bf3854bf3874af48849f48948f58b47f58c46f68d45f68f44f79044f79143f79342f89441f89540f9973ff9983ef99a3efa9b3dfa9c3cfa9e3bfb9f3afba139fba238fca338fca537fca636fca835fca934fdab33fdac33fdae32fdaf31fdb130fdb22ffdb42ffdb52efeb72dfeb82cfeba2cfebb2bfebd2afebe2afec029fdc229fdc328fdc527fdc627fdc827fdca26fdcb26fccd25fcce25fcd025fcd225fbd324fbd524fbd724fad824fada24f9dc24f9dd25f8df25f8e125f7e225f7e425f6e626f6e826f5e926f5eb27f4ed27f3ee27f3f027f2f227f1f426f1f525f0f724f0f921"};var nr=256,hp={pressure:"viridis",taxels:"viridis",deformation:"cividis",uncertainty:"plasma"},cp={dark:.12,bright:.22},du=new Map;function P_(){return Object.keys($a)}function Br(i,t=null){if(!(i in $a))throw new RangeError(`colour map ${i}: one of ${P_()}`);let e=t?`${i} ${t.plain} ${t.bright}`:i;return du.has(e)||du.set(e,t?I_(Br(i),t):N_($a[i])),du.get(e)}function I_(i,{plain:t,bright:e}){let n=new Uint8Array(i.length).fill(255),s=[1,3,5].map(r=>Number.parseInt(t.slice(r,r+2),16));for(let r=0;r<nr;r+=1){let o=Math.min(1,r/((e?cp.bright:cp.dark)*(nr-1))),a=o*o*(3-2*o),l=4*(e?nr-1-r:r);for(let c=0;c<3;c+=1)n[4*r+c]=Math.round(s[c]+a*(i[l+c]-s[c]))}return n}function L_(i,t,e=null){let n=Br(i,e),s=4*Math.min(nr-1,Math.max(0,Math.round(t*(nr-1))));return[n[s],n[s+1],n[s+2]]}function up(i,t="to right",e=null){let n=[];for(let s=0;s<=64;s+=1)n.push(`rgb(${L_(i,s/64,e).join(" ")})`);return`linear-gradient(${t}, ${n.join(", ")})`}function N_(i){let t=new Uint8Array(4*nr);for(let e=0;e<nr;e+=1){for(let n=0;n<3;n+=1)t[4*e+n]=Number.parseInt(i.slice(6*e+2*n,6*e+2*n+2),16);t[4*e+3]=255}return t}var Is={dark:{background:"#10131a",ink:"#eef1f7",muted:"#a3adbd",panel:"#1b202b",edge:"#323a4a",contact:"#ff7a55",truth:"#62cbff",missing:"#232832",plain:"#333a48",bright:!1,rim:"#8490a8",casing:"#0b0d12",dot:"#ffffff",line:"#ffffff",onSkin:{contact:"#ffb59c",truth:"#bfe8ff",focus:"#ffffff",tool:"#ffffff"}},light:{background:"#f5f6f9",ink:"#171c28",muted:"#566072",panel:"#ffffff",edge:"#cfd5df",contact:"#d63d17",truth:"#0a66b8",missing:"#b3bac6",plain:"#d3d9e2",bright:!0,rim:"#7d8799",casing:"#ffffff",dot:"#2b3342",line:"#2b3342",onSkin:{contact:"#b32c0b",truth:"#08518f",focus:"#171c28",tool:"#171c28"}}},fp="#ff4d5e";var dp={pressure:"Pressure",deformation:"Deformation",uncertainty:"Uncertainty",taxels:"Readings"},D_={Pa:1e4,relative:1e4,m:1e-4},Ya=class{#t=new qa;#i=null;#n="";#e="";#s=null;#a;#r=X("range-auto");#o=X("range-hi");#h={label:"",factor:1};constructor(t){this.#a=t,this.#r.addEventListener("change",()=>this.#c()),this.#o.addEventListener("input",()=>this.#f())}reset(){this.#i=null,this.#t.reset()}recolour(t){this.#s=Is[t],this.#e="",this.#f()}follow({quantity:t,unit:e,range:n},s){(t!==this.#i||(e??"")!==this.#n)&&(this.#i=t,this.#n=e??"",this.#t.reset(D_[e]),this.#r.checked||(this.#r.checked=!0),this.#c()),this.#t.follow(Array.isArray(n)?n:[],s),this.#f()}#u(){let[t,e]=this.#t.value,n=Number(this.#o.value)*this.#h.factor;return this.#r.checked||!(n>0)?[t,e]:[Math.min(t,0),n]}#c(){this.#o.disabled=this.#r.checked,this.#e="",this.#f()}#f(){let[t,e]=this.#u(),n=hp[this.#i]??"viridis",s=`${t} ${e} ${n} ${this.#n} ${this.#r.checked}`;if(s===this.#e)return;this.#e=s,this.#r.checked&&(this.#h=lu(e,this.#n));let{factor:r,label:o}=this.#h;X("colour-map").style.background=up(n,"to right",this.#s);let a=Wa(t/r,e/r,5),l=Xa(a[1]-a[0]);X("colour-ticks").replaceChildren(...a.map(h=>U_(Gt(h,l),(h*r-t)/(e-t)))),le(X("range-unit"),o||"–"),le(X("colour-name"),`${dp[this.#i]??""}${o?`, ${o}`:""}`),this.#r.checked&&(this.#o.value=Number((e/r).toPrecision(6)));let c=`${dp[this.#i]??"Colour bar"} from ${[t,e].map(h=>Cs(h/r)).join(" to ")} ${o}`;X("colour-bar").setAttribute("aria-label",c),this.#a({lo:t,hi:e,map:n})}};function U_(i,t){let e=qt("span",{text:i});return e.style.left=`${100*t}%`,t<.03&&(e.className="first"),t>.97&&(e.className="last"),e}function Za(i,t){let e=[];i.forEach((r,o)=>t.forEach((a,l)=>{let c=F_(r,a);r.patch===a.patch&&c<=.03&&e.push({i:o,j:l,apart:c})})),e.sort((r,o)=>r.apart-o.apart);let n=i.map(r=>({contact:r,truth:null,error_m:NaN,error_percent:NaN})),s=new Set;for(let{i:r,j:o,apart:a}of e){if(n[r].truth||s.has(o))continue;s.add(o);let l=t[o],c=l.force>0?100*(i[r].force-l.force)/l.force:NaN;n[r]={contact:i[r],truth:l,error_m:a,error_percent:c}}return n}function Ja(i,t){let e=new Set(i.map(({truth:n})=>n));return t.filter(n=>!e.has(n)&&n.force>0)}function F_(i,t){return Math.hypot(i.x-t.x,i.y-t.y)}var O_=4,Ka=class{#t=X("contacts-table");#i=this.#t.tBodies[0];#n={at:-1/0,count:-1};show(t,e,{now:n,patchName:s,slotOf:r,none:o,relative:a}){let l=Ja(t,e),c=[...t.toSorted(B_).map(h=>k_(h,s,r)),...l.map(h=>H_(h,s))];c.length===0&&c.push(pp(o)),this.#t.classList.toggle("has-shear",t.some(({contact:h,truth:f})=>h.shear||f?.shear)),this.#i.replaceChildren(...c),this.#e(t,n,a)}clear(){this.#i.replaceChildren(pp()),le(X("contacts-total"),"")}#e(t,e,n){let s=t.reduce((c,{contact:h})=>c+h.force,0);le(X("contacts-total"),t.length?`${t.length} · ${Gt(s,2)} ${tr(n)} in all`:"");let{at:r,count:o}=this.#n;if(e-r<O_||t.length===o&&t.length===0)return;this.#n={at:e,count:t.length};let a=t.slice(0,4).map(({contact:c})=>`${Gt(c.force,1)} ${n?"relative":"newtons"} at ${pu(c)} millimetres${c.maybe?`, perhaps ${Or(c.maybe)}`:""}`),l=t.length?`${t.length} contact${t.length>1?"s":""}: ${a.join("; ")}`:"No contact";le(X("contacts-summary"),l)}};function B_({contact:i},{contact:t}){return i.patch-t.patch||i.track-t.track}function k_({contact:i,truth:t,error_m:e,error_percent:n},s,r){let o=qt("tr",{...V_(i,t,e,n),class:i.old?"old":null},qt("th",{scope:"row",title:lp(i)},G_(r(i.key)),` ${i.track}`,W_(i)),qt("td",{text:s(i.patch),title:s(i.patch),class:"patch"}),qt("td",{class:"n",text:pu(i)}),qt("td",{class:"n",text:Fo(i)}),z_(i),qt("td",{class:"n area",text:Gt(1e6*i.area,0)}),qt("td",{class:"n truth",text:t?Gt(t.force,2):""}),qt("td",{class:"n truth",text:t?Gt(1e3*e,1):""}),qt("td",{class:"n truth",text:t?X_(n):""}));return o.style.setProperty("--fade",Gt(i.fade??0,2)),o}function z_({shear:i}){if(!i)return qt("td",{class:"n along"});let t=qt("i",{"aria-hidden":"true",text:"→"});return t.style.rotate=`${Gt(-mp(i),0).replace("−","-")}deg`,qt("td",{class:"n along",title:cu(i)},t,` ${Gt(i.size,2)}`)}function V_(i,t,e,n){let{shear:s}=i,r={"data-track":i.track,"data-key":i.key,"data-age-ms":Wn(i.age_ms,0),"data-patch":i.patch,"data-x-mm":Wn(1e3*i.x,3),"data-y-mm":Wn(1e3*i.y,3),"data-force":Wn(i.force,4),"data-force-std":Wn(i.force_std,4),"data-area-mm2":Wn(1e6*i.area,2),"data-shear":s?Wn(s.size,4):null,"data-shear-std":s?Wn(s.std,4):null,"data-shear-degrees":s?Wn(mp(s),1):null,"data-shape":i.shape,"data-maybe":i.maybe||null};return t?{...r,"data-truth-force":Wn(t.force,4),"data-truth-x-mm":Wn(1e3*t.x,3),"data-truth-y-mm":Wn(1e3*t.y,3),"data-truth-shear":t.shear?Wn(t.shear.size,4):null,"data-error-mm":Wn(1e3*e,3),"data-error-percent":Wn(Math.abs(n),2)}:r}function H_(i,t){return qt("tr",{class:"missed","data-missed":i.id},qt("th",{scope:"row",text:"–"}),qt("td",{text:t(i.patch),class:"patch"}),qt("td",{class:"n",text:pu(i)}),qt("td",{class:"n",text:"not found"}),qt("td",{class:"n along"}),qt("td",{class:"area"}),qt("td",{class:"n truth",text:Gt(i.force,2)}),qt("td",{class:"truth",colspan:"2"}))}function pp(i="No contact"){return qt("tr",{class:"empty"},qt("td",{colspan:"9",text:i}))}function G_(i){let t=qt("i",{class:"swatch","aria-hidden":"true"});return i>=0&&(t.style.background=`var(--slot-${i})`),t}function W_({maybe:i}){return i?qt("small",{class:"or-two",text:` · ${Or(i)}?`}):null}function mp({angle:i}){return 180*i/Math.PI}function pu({x:i,y:t}){return`${Gt(1e3*i,1)}, ${Gt(1e3*t,1)}`}function X_(i){return i>0?`+${Gt(i,0)}`:Gt(i,0)}function Wn(i,t){return Number.isFinite(i)?Number(i.toFixed(t)):null}var q_=4,gp={info:6e3,warn:1e4,error:15e3},kr=new Map;function Xi(i,t){let e=i in gp?i:"info",n=kr.get(t)??$_(e,t);for(n.times+=1,n.item.querySelector(".times").textContent=n.times>1?`×${n.times}`:"",clearTimeout(n.timer),n.timer=setTimeout(()=>mu(t),gp[e]);kr.size>q_;)mu(kr.keys().next().value)}function mu(i){let t=kr.get(i);t&&(clearTimeout(t.timer),t.item.remove(),kr.delete(i))}function $_(i,t){let e=qt("button",{type:"button",class:"quiet","aria-label":"Dismiss",text:"✕"}),n=qt("div",{class:`notice ${i}`,role:i==="error"?"alert":null},qt("p",{},qt("span",{text:t}),qt("span",{class:"times"})),e);e.addEventListener("click",()=>mu(t)),X("notices").append(n);let s={item:n,times:0,timer:null};return kr.set(t,s),s}var gu={resolution:"resolution",solver:"solver"},ja={deadline_us:"deadline",smoothing_ms:"smoothing",threshold_N:"threshold"},Qa={resolution:"Resolution",solver:"Solver",deadline_us:"Deadline",smoothing_ms:"Smoothing",threshold_N:"Threshold",focus:"Focus",tare:"Tare",record:"Recording",press:"Pressing"},Y_=700,el=class{#t;#i;#n=null;#e=new Wi(()=>this.#r());#s=!1;#a;constructor(t,e,n){this.#t=t,this.#i=e,this.#a=n;for(let[s,r]of Object.entries(gu))X(r).addEventListener("change",()=>this.#m(s,J_(X(r).value)));for(let[s,r]of Object.entries(ja))this.#d(s,X(r));X("focus").addEventListener("click",()=>this.draw(!this.#s)),X("focus-clear").addEventListener("click",()=>this.#m("focus",null)),X("tare").addEventListener("click",()=>this.tare()),X("record").addEventListener("click",()=>this.record())}tare(){X("tare").disabled||this.#x(X("tare"),{do:"tare"})}record(){let t=!this.#n?.recording;X("record").disabled||this.#x(X("record"),{do:"record",on:t})}draw(t){this.#s=t&&!X("focus").disabled,X("focus").setAttribute("aria-pressed",String(this.#s)),le(X("focus"),this.#s?"Drag on the skin …":"Draw focus"),this.#i.setMode(this.#s?"focus":"press")}get drawing(){return this.#s}focusDrawn(t){this.draw(!1),this.#m("focus",t)}show(t){this.#n=t,this.#e.settled(),this.#r();let e=t.off??{};this.#c(t.focus??null,e.focus),gi(X("tare"),e.tare),this.#l(t.recording??null,e.record),this.#p(e);let n=t.busy??"";le(X("busy"),n),X("busy").title=n}#r(){let t=this.#n??{},e=t.off??{};for(let[n,s]of Object.entries(gu))this.#h(n,X(s),t[n],e[n]);for(let[n,s]of Object.entries(ja))this.#u(n,X(s),t[n],e[n]);this.#o(X("focus"),this.#e.has("focus"))}#o(t,e){e?t.setAttribute("aria-busy","true"):t.removeAttribute("aria-busy")}#h(t,e,n,s){let r=this.#e.has(t);if(this.#o(e,r||n?.preparing!=null),gi(e,s??(n?null:"the engine does not tell it")),!n)return;let o=(n.options??[n.value]).map(l=>[l,String(l)]);Rs(e,t==="solver"?Z_(o):o);let a=String(n.preparing??n.value);!r&&e.value!==a&&(e.value=a)}#u(t,e,n,s){let r=this.#e.has(t);if(this.#o(e,r),gi(e,s??(n?null:"the engine does not tell it")),!n)return;let[o,a]=(n.range??[]).map(xu);Number.isFinite(o)&&(e.min=o),Number.isFinite(a)&&(e.max=a),e.dataset.inForce=xu(n.value),!e.dataset.typing&&!r&&(e.value=xu(n.value)),!s&&Number.isFinite(a)&&(e.title=`${o} to ${a}`)}#c(t,e){gi(X("focus"),e),gi(X("focus-clear"),e??(t?null:"there is no window")),le(X("focus-text"),t?this.#f(t):""),this.#i.setFocus?.(t)}#f({patch:t,low:e,high:n}){let s=[0,1].map(o=>Gt(1e3*(n[o]-e[o]),0)),r=typeof t=="number"?this.#a(t):t;return`focus ${s.join(" × ")} mm on ${r}`}#l(t,e){let n=X("record");gi(n,e),n.setAttribute("aria-pressed",String(!!t)),le(X("record-label"),t?"Stop":"Record");let s=t?`${Ps(t.seconds)} · ${Ga(t.bytes)}`:"";le(X("record-text"),s),X("record-text").title=t?.file??"",X("record-off").hidden=!e,le(X("record-off"),e?_u(e):"")}#p(t){let e=new Map;for(let[o,a]of Object.entries(t))["press","record"].includes(o)||!(o in Qa)||e.set(a,[...e.get(a)??[],Qa[o]]);let n=X("controls-off");n.hidden=e.size===0;let s=Object.keys(Qa).length-2,r=[...e].map(([o,a])=>qt("li",{text:a.length>=s?_u(o):`${a.join(", ")}: ${o}`}));n.replaceChildren(...r)}#d(t,e){let n=null,s=()=>{if(clearTimeout(n),!e.dataset.typing)return;delete e.dataset.typing;let r=this.#g(t,e),o=this.#e.has(t)||r!==Number(e.dataset.inForce);Number.isFinite(r)&&o?this.#m(t,r):e.value=e.dataset.inForce};e.addEventListener("input",()=>{e.dataset.typing="yes",clearTimeout(n),n=setTimeout(s,Y_)}),e.addEventListener("change",s)}#g(t,{valueAsNumber:e,min:n,max:s}){if(!Number.isFinite(e)||n===""||s==="")return e;let r=Uo(e,Number(n),Number(s));return r!==e&&Xi("info",`${Qa[t]} can be ${n} to ${s}: taken as ${r}.`),r}#m(t,e){let n=X(gu[t]??ja[t]??t);return t in ja&&(n.value=e),this.#o(n,!0),this.#e.wait(t,this.#t({do:"set",what:t,value:e}))}async#x(t,e){t.setAttribute("aria-busy","true"),await this.#t(e),t.removeAttribute("aria-busy")}},tl={auto:["Use","Auto"],contact:["Use","ContactFit"],nonnegative:["Use","NonNegative"],gaussian:["Study","Gaussian, linear"],tikhonov:["Study","Tikhonov, the paper's"],"pseudo-inverse":["Study","Pseudo-inverse, the paper's"],inverse:["Study","Inverse, the paper's"]};function Z_(i){let t=Object.keys(tl),e=([s])=>s in tl?t.indexOf(s):t.length;return i.map(([s,r])=>[s,tl[s]?.[1]??r,tl[s]?.[0]??"Study"]).sort((s,r)=>e(s)-e(r))}function gi(i,t){i.disabled=!!t,i.dataset.title===void 0&&(i.dataset.title=i.title),i.title=t?_u(t):i.dataset.title}function xu(i){return Number(Number(i).toPrecision(6))}function J_(i){return i!==""&&Number.isFinite(Number(i))?Number(i):i}function _u(i){return i.charAt(0).toUpperCase()+i.slice(1)+(/[.!?]$/.test(i)?"":".")}var _p=matchMedia("(prefers-color-scheme: dark)");function vp(i){let t=()=>{let e=K_()??xp();document.documentElement.dataset.theme=e,i(e)};X("theme").addEventListener("click",()=>{let e=document.documentElement.dataset.theme==="dark"?"light":"dark";za("theme",e===xp()?null:e),t()}),_p.addEventListener("change",t),t()}function K_(){let i=ka("theme");return i==="dark"||i==="light"?i:null}function xp(){return _p.matches?"dark":"light"}function An(i){return getComputedStyle(document.documentElement).getPropertyValue(i).trim()}var j_=46,zr={width:180,height:10},Q_='12px system-ui, "Segoe UI", Roboto, sans-serif';function yp(i,t){bp(i,new Blob([t],{type:"text/csv;charset=utf-8"}))}function bp(i,t){let e=document.createElement("a");e.href=URL.createObjectURL(t),e.download=i.replace(/[^\w.-]+/g,"_"),e.click(),setTimeout(()=>URL.revokeObjectURL(e.href),1e4)}function Sp(i,t,e){t.draw();let{width:n,height:s}=t.canvas,r=n/Math.max(t.canvas.clientWidth,1),o=Object.assign(document.createElement("canvas"),{width:n,height:s+j_*r}),a=o.getContext("2d");a.fillStyle=An("--panel"),a.fillRect(0,0,o.width,o.height),a.drawImage(t.canvas,0,0),a.scale(r,r),tv(a,s/r,t.table.image.data,e),o.toBlob(l=>l&&bp(i,l),"image/png")}function tv(i,t,e,n){for(let s=0;s<256;s+=1)i.fillStyle=`rgb(${e[4*s]} ${e[4*s+1]} ${e[4*s+2]})`,i.fillRect(12+s*zr.width/256,t+10,zr.width/256+.6,zr.height);Object.assign(i,{font:Q_,fillStyle:An("--muted"),textBaseline:"top"});for(let s of X("colour-ticks").children){let r=parseFloat(s.style.left)/100;i.textAlign=r<.03?"left":r>.97?"right":"center",i.fillText(s.textContent,12+r*zr.width,t+25)}i.textAlign="left",i.fillText(n[0],zr.width+28,t+8),i.fillText(n[1],zr.width+28,t+25)}var nl=class{#t=[];#i=new Map;#n=null;#e=0;#s=!1;#a;#r;constructor({seconds:t=30,bytes:e=32e6}={}){this.#a=t,this.#r=e}get length(){return this.#t.length}get held(){return this.#s}get seconds(){return this.#a}get start(){return this.#t[0]?.time??NaN}get end(){return this.#t.at(-1)?.time??NaN}add(t,e,n,s=0){if(!Number.isFinite(t))return;let r=new Map((e.patches??[]).map(a=>[a.i,{entry:a,arrays:n}])),o={time:t,head:e,parts:r,bytes:s};this.#s?this.#n=this.#n?Mp(this.#n,o):o:this.#o(o)}hold(){return this.#s=this.length>0,this.#s}release(){this.#s=!1,this.#n&&this.#o(this.#n),this.#n=null}clear(){this.#t=[],this.#i.clear(),this.#n=null,this.#s=!1,this.#e=0}placeAt(t){let[e,n]=[0,this.length-1];for(;e<n;){let s=Math.ceil((e+n)/2);this.#t[s].time<=t?e=s:n=s-1}return e}moment(t){let{time:e,head:n}=this.#t[t],s=new Map(this.#i);for(let r of this.#t.slice(0,t+1))for(let[o,a]of r.parts)s.set(o,a);return{time:e,head:n,parts:s}}outline(){let t=new Map;for(let{time:e,head:n}of this.#t)for(let{key:s}of n.contacts){let[r]=t.get(s)??[e];t.set(s,[r,e])}return{times:this.#t.map(({time:e})=>e),force:this.#t.map(({head:e})=>vu(e.contacts)),touches:[...t.values()]}}rows(){return[...new Set(this.#t.flatMap(({head:e})=>e.rows??[]))]}#o(t){this.length&&t.time<this.end&&this.clear();let e=this.#t.at(-1);for(e?.time===t.time?(this.#e+=t.bytes,this.#t[this.length-1]=Mp(e,t)):(this.#t.push(t),this.#e+=t.bytes);this.length>1&&(this.start<this.end-this.#a||this.#e>this.#r);){let{parts:n,bytes:s}=this.#t.shift();for(let[r,o]of n)this.#i.set(r,o);this.#e-=s}}};function Mp(i,t){return{...t,parts:new Map([...i.parts,...t.parts]),bytes:i.bytes+t.bytes}}function vu(i){return i.reduce((t,{force:e})=>t+e,0)}var il={ArrowLeft:[-1,0],ArrowRight:[1,0],ArrowUp:[0,1],ArrowDown:[0,-1]},wp={a:[-.12,0],d:[.12,0],w:[0,-.12],s:[0,.12]},ev=["pressure","deformation","uncertainty","taxels"];function Ep(i){document.addEventListener("keydown",t=>{if(t.ctrlKey||t.metaKey||t.altKey||t.defaultPrevented||document.querySelector("dialog[open]"))return;let e=nv(t,i);!e||sv(t.target,t.key)||(t.preventDefault(),e())})}function nv({key:i,repeat:t,shiftKey:e},n){let s=i.length===1?i.toLowerCase():i;if(i in il)return()=>iv(il[i],e?.005:.001,n);if(i==="+"||i==="=")return()=>n.harder(.1)||n.zoom(1.14);if(i==="-"||i==="−")return()=>n.harder(-.1)||n.zoom(1/1.14);if(s in wp)return()=>n.orbit(...wp[s]);if(s==="e"||s==="q")return()=>n.zoom(s==="e"?1.14:1/1.14);if(i==="."||i===",")return()=>n.step(i==="."?1:-1);if(t)return null;let r=ev[Number(i)-1];if(r&&i.length===1)return()=>n.quantity(r);let a={Home:"home",Escape:"lift","?":"help"," ":"play",t:"tare",r:"record",p:"press",l:"loop"}[s];return a?()=>n[a]():null}function iv([i,t],e,n){n.shift(i*e,t*e)||n.orbit(i*.12,-t*.12)}function sv(i,t){return!(i instanceof Element)||t==="Escape"?!1:i.matches("textarea, select, [contenteditable]")||i.matches("input:not([type=checkbox], [type=range])")?!0:i.matches("input[type=range]")?t in il||t==="Home":i.matches("[tabindex='0']")&&i.scrollHeight>i.clientHeight?t in il:t===" "&&i.matches("button, a, summary, input")}var rv="uplot",ov="u-hz",av="u-vt",lv="u-title",cv="u-wrap",hv="u-under",uv="u-over",fv="u-axis",rr="u-off",dv="u-select",pv="u-cursor-x",mv="u-cursor-y",gv="u-cursor-pt",xv="u-legend",_v="u-live",vv="u-inline",yv="u-series",bv="u-marker",Tp="u-label",Sv="u-value",Bo="width",ko="height";var Ap="bottom",Vr="left",yu="right",Ou="#000",Rp=Ou+"0",bu="mousemove",Cp="mousedown",Su="mouseup",Pp="mouseenter",Ip="mouseleave",Lp="dblclick",Mv="resize",wv="scroll",Np="change",ll="dppxchange",Bu="--",Yr=typeof window<"u",Au=Yr?document:null,Gr=Yr?window:null,Ev=Yr?navigator:null,Te,sl;function Ru(){let i=devicePixelRatio;Te!=i&&(Te=i,sl&&Pu(Np,sl,Ru),sl=matchMedia(`(min-resolution: ${Te-.001}dppx) and (max-resolution: ${Te+.001}dppx)`),or(Np,sl,Ru),Gr.dispatchEvent(new CustomEvent(ll)))}function ii(i,t){if(t!=null){let e=i.classList;!e.contains(t)&&e.add(t)}}function Cu(i,t){let e=i.classList;e.contains(t)&&e.remove(t)}function We(i,t,e){i.style[t]=e+"px"}function Ei(i,t,e,n){let s=Au.createElement(i);return t!=null&&ii(s,t),e?.insertBefore(s,n),s}function xi(i,t){return Ei("div",i,t)}var Dp=new WeakMap;function qi(i,t,e,n,s){let r="translate("+t+"px,"+e+"px)",o=Dp.get(i);r!=o&&(i.style.transform=r,Dp.set(i,r),t<0||e<0||t>n||e>s?ii(i,rr):Cu(i,rr))}var Up=new WeakMap;function Fp(i,t,e){let n=t+e,s=Up.get(i);n!=s&&(Up.set(i,n),i.style.background=t,i.style.borderColor=e)}var Op=new WeakMap;function Bp(i,t,e,n){let s=t+""+e,r=Op.get(i);s!=r&&(Op.set(i,s),i.style.height=e+"px",i.style.width=t+"px",i.style.marginLeft=n?-t/2+"px":0,i.style.marginTop=n?-e/2+"px":0)}var ku={passive:!0},Tv={...ku,capture:!0};function or(i,t,e,n){t.addEventListener(i,e,n?Tv:ku)}function Pu(i,t,e,n){t.removeEventListener(i,e,ku)}Yr&&Ru();function Ti(i,t,e,n){let s;e=e||0,n=n||t.length-1;let r=n<=2147483647;for(;n-e>1;)s=r?e+n>>1:si((e+n)/2),t[s]<i?e=s:n=s;return i-t[e]<=t[n]-i?e:n}function fm(i){return(e,n,s)=>{let r=-1,o=-1;for(let a=n;a<=s;a++)if(i(e[a])){r=a;break}for(let a=s;a>=n;a--)if(i(e[a])){o=a;break}return[r,o]}}var dm=i=>i!=null,pm=i=>i!=null&&i>0,ul=fm(dm),Av=fm(pm);function Rv(i,t,e,n=0,s=!1){let r=s?Av:ul,o=s?pm:dm;[t,e]=r(i,t,e);let a=i[t],l=i[t];if(t>-1)if(n==1)a=i[t],l=i[e];else if(n==-1)a=i[e],l=i[t];else for(let c=t;c<=e;c++){let h=i[c];o(h)&&(h<a?a=h:h>l&&(l=h))}return[a??Fe,l??-Fe]}function fl(i,t,e,n){let s=Vp(i),r=Vp(t);i==t&&(s==-1?(i*=e,t/=e):(i/=e,t*=e));let o=e==10?as:mm,a=s==1?si:_i,l=r==1?_i:si,c=a(o(vn(i))),h=l(o(vn(t))),f=Wr(e,c),u=Wr(e,h);return e==10&&(c<0&&(f=Oe(f,-c)),h<0&&(u=Oe(u,-h))),n||e==2?(i=f*s,t=u*r):(i=vm(i,f),t=dl(t,u)),[i,t]}function zu(i,t,e,n){let s=fl(i,t,e,n);return i==0&&(s[0]=0),t==0&&(s[1]=0),s}var Vu=.1,kp={mode:3,pad:Vu},Vo={pad:0,soft:null,mode:0},Cv={min:Vo,max:Vo};function cl(i,t,e,n){return pl(e)?zp(i,t,e):(Vo.pad=e,Vo.soft=n?0:null,Vo.mode=n?3:0,zp(i,t,Cv))}function Me(i,t){return i??t}function Pv(i,t,e){for(t=Me(t,0),e=Me(e,i.length-1);t<=e;){if(i[t]!=null)return!0;t++}return!1}function zp(i,t,e){let n=e.min,s=e.max,r=Me(n.pad,0),o=Me(s.pad,0),a=Me(n.hard,-Fe),l=Me(s.hard,Fe),c=Me(n.soft,Fe),h=Me(s.soft,-Fe),f=Me(n.mode,0),u=Me(s.mode,0),d=t-i,g=as(d),M=Xn(vn(i),vn(t)),m=as(M),p=vn(m-g);(d<1e-24||p>10)&&(d=0,(i==0||t==0)&&(d=1e-24,f==2&&c!=Fe&&(r=0),u==2&&h!=-Fe&&(o=0)));let y=d||M||1e3,A=as(y),w=Wr(10,si(A)),P=y*(d==0?i==0?.1:1:r),T=Oe(vm(i-P,w/10),24),_=i>=c&&(f==1||f==3&&T<=c||f==2&&T>=c)?c:Fe,E=Xn(a,T<_&&i>=_?_:Ai(_,T)),V=y*(d==0?t==0?.1:1:o),D=Oe(dl(t+V,w/10),24),L=t<=h&&(u==1||u==3&&D>=h||u==2&&D<=h)?h:-Fe,H=Ai(l,D>L&&t<=L?L:Xn(L,D));return E==H&&E==0&&(H=100),[E,H]}var Iv=new Intl.NumberFormat(Yr?Ev.language:"en-US"),Hu=i=>Iv.format(i),ri=Math,al=ri.PI,vn=ri.abs,si=ri.floor,_n=ri.round,_i=ri.ceil,Ai=ri.min,Xn=ri.max,Wr=ri.pow,Vp=ri.sign,as=ri.log10,mm=ri.log2,Lv=(i,t=1)=>ri.sinh(i)*t,Mu=(i,t=1)=>ri.asinh(i/t),Fe=1/0;function Hp(i){return(as((i^i>>31)-(i>>31))|0)+1}function Iu(i,t,e){return Ai(Xn(i,t),e)}function gm(i){return typeof i=="function"}function ve(i){return gm(i)?i:()=>i}var Nv=()=>{},xm=i=>i,_m=(i,t)=>t,Dv=i=>null,Gp=i=>!0,Wp=(i,t)=>i==t,Uv=/\.\d*?(?=9{6,}|0{6,})/gm,ar=i=>{if(bm(i)||Ns.has(i))return i;let t=`${i}`,e=t.match(Uv);if(e==null)return i;let n=e[0].length-1;if(t.indexOf("e-")!=-1){let[s,r]=t.split("e");return+`${ar(s)}e${r}`}return Oe(i,n)};function ir(i,t){return ar(Oe(ar(i/t))*t)}function dl(i,t){return ar(_i(ar(i/t))*t)}function vm(i,t){return ar(si(ar(i/t))*t)}function Oe(i,t=0){if(bm(i))return i;let e=10**t,n=i*e*(1+Number.EPSILON);return _n(n)/e}var Ns=new Map;function ym(i){return((""+i).split(".")[1]||"").length}function Go(i,t,e,n){let s=[],r=n.map(ym);for(let o=t;o<e;o++){let a=vn(o),l=Oe(Wr(i,o),a);for(let c=0;c<n.length;c++){let h=i==10?+`${n[c]}e${o}`:n[c]*l,f=(o>=0?0:a)+(o>=r[c]?0:r[c]),u=i==10?h:Oe(h,f);s.push(u),Ns.set(u,f)}}return s}var Ho={},Gu=[],Xr=[null,null],Ls=Array.isArray,bm=Number.isInteger,Fv=i=>i===void 0;function Xp(i){return typeof i=="string"}function pl(i){let t=!1;if(i!=null){let e=i.constructor;t=e==null||e==Object}return t}function Ov(i){return i!=null&&typeof i=="object"}var Bv=Object.getPrototypeOf(Uint8Array),Sm="__proto__";function qr(i,t=pl){let e;if(Ls(i)){let n=i.find(s=>s!=null);if(Ls(n)||t(n)){e=Array(i.length);for(let s=0;s<i.length;s++)e[s]=qr(i[s],t)}else e=i.slice()}else if(i instanceof Bv)e=i.slice();else if(t(i)){e={};for(let n in i)n!=Sm&&(e[n]=qr(i[n],t))}else e=i;return e}function dn(i){let t=arguments;for(let e=1;e<t.length;e++){let n=t[e];for(let s in n)s!=Sm&&(pl(i[s])?dn(i[s],qr(n[s])):i[s]=qr(n[s]))}return i}var kv=0,zv=1,Vv=2;function Hv(i,t,e){for(let n=0,s,r=-1;n<t.length;n++){let o=t[n];if(o>r){for(s=o-1;s>=0&&i[s]==null;)i[s--]=null;for(s=o+1;s<e&&i[s]==null;)i[r=s++]=null}}}function Gv(i,t){if(qv(i)){let o=i[0].slice();for(let a=1;a<i.length;a++)o.push(...i[a].slice(1));return $v(o[0])||(o=Xv(o)),o}let e=new Set;for(let o=0;o<i.length;o++){let l=i[o][0],c=l.length;for(let h=0;h<c;h++)e.add(l[h])}let n=[Array.from(e).sort((o,a)=>o-a)],s=n[0].length,r=new Map;for(let o=0;o<s;o++)r.set(n[0][o],o);for(let o=0;o<i.length;o++){let a=i[o],l=a[0];for(let c=1;c<a.length;c++){let h=a[c],f=Array(s).fill(void 0),u=t?t[o][c]:zv,d=[];for(let g=0;g<h.length;g++){let M=h[g],m=r.get(l[g]);M===null?u!=kv&&(f[m]=M,u==Vv&&d.push(m)):f[m]=M}Hv(f,d,s),n.push(f)}}return n}var Wv=typeof queueMicrotask>"u"?i=>Promise.resolve().then(i):queueMicrotask;function Xv(i){let t=i[0],e=t.length,n=Array(e);for(let r=0;r<n.length;r++)n[r]=r;n.sort((r,o)=>t[r]-t[o]);let s=[];for(let r=0;r<i.length;r++){let o=i[r],a=Array(e);for(let l=0;l<e;l++)a[l]=o[n[l]];s.push(a)}return s}function qv(i){let t=i[0][0],e=t.length;for(let n=1;n<i.length;n++){let s=i[n][0];if(s.length!=e)return!1;if(s!=t){for(let r=0;r<e;r++)if(s[r]!=t[r])return!1}}return!0}function $v(i,t=100){let e=i.length;if(e<=1)return!0;let n=0,s=e-1;for(;n<=s&&i[n]==null;)n++;for(;s>=n&&i[s]==null;)s--;if(s<=n)return!0;let r=Xn(1,si((s-n+1)/t));for(let o=i[n],a=n+r;a<=s;a+=r){let l=i[a];if(l!=null){if(l<=o)return!1;o=l}}return!0}var Mm=["January","February","March","April","May","June","July","August","September","October","November","December"],wm=["Sunday","Monday","Tuesday","Wednesday","Thursday","Friday","Saturday"];function Em(i){return i.slice(0,3)}var Yv=wm.map(Em),Zv=Mm.map(Em),Jv={MMMM:Mm,MMM:Zv,WWWW:wm,WWW:Yv};function Oo(i){return(i<10?"0":"")+i}function Kv(i){return(i<10?"00":i<100?"0":"")+i}var jv={YYYY:i=>i.getFullYear(),YY:i=>(i.getFullYear()+"").slice(2),MMMM:(i,t)=>t.MMMM[i.getMonth()],MMM:(i,t)=>t.MMM[i.getMonth()],MM:i=>Oo(i.getMonth()+1),M:i=>i.getMonth()+1,DD:i=>Oo(i.getDate()),D:i=>i.getDate(),WWWW:(i,t)=>t.WWWW[i.getDay()],WWW:(i,t)=>t.WWW[i.getDay()],HH:i=>Oo(i.getHours()),H:i=>i.getHours(),h:i=>{let t=i.getHours();return t==0?12:t>12?t-12:t},AA:i=>i.getHours()>=12?"PM":"AM",aa:i=>i.getHours()>=12?"pm":"am",a:i=>i.getHours()>=12?"p":"a",mm:i=>Oo(i.getMinutes()),m:i=>i.getMinutes(),ss:i=>Oo(i.getSeconds()),s:i=>i.getSeconds(),fff:i=>Kv(i.getMilliseconds())};function Wu(i,t){t=t||Jv;let e=[],n=/\{([a-z]+)\}|[^{]+/gi,s;for(;s=n.exec(i);)e.push(s[0][0]=="{"?jv[s[1]]:s[0]);return r=>{let o="";for(let a=0;a<e.length;a++)o+=typeof e[a]=="string"?e[a]:e[a](r,t);return o}}var Qv=new Intl.DateTimeFormat().resolvedOptions().timeZone;function ty(i,t){let e;return t=="UTC"||t=="Etc/UTC"?e=new Date(+i+i.getTimezoneOffset()*6e4):t==Qv?e=i:(e=new Date(i.toLocaleString("en-US",{timeZone:t})),e.setMilliseconds(i.getMilliseconds())),e}var Tm=i=>i%1==0,hl=[1,2,2.5,5],ey=Go(10,-32,0,hl),Am=Go(10,0,32,hl),ny=Am.filter(Tm),sr=ey.concat(Am),Xu=`
`,Rm="{YYYY}",qp=Xu+Rm,Cm="{M}/{D}",zo=Xu+Cm,rl=zo+"/{YY}",Pm="{aa}",iy="{h}:{mm}",Hr=iy+Pm,$p=Xu+Hr,Yp=":{ss}",Ae=null;function Im(i){let t=i*1e3,e=t*60,n=e*60,s=n*24,r=s*30,o=s*365,l=(i==1?Go(10,0,3,hl).filter(Tm):Go(10,-3,0,hl)).concat([t,t*5,t*10,t*15,t*30,e,e*5,e*10,e*15,e*30,n,n*2,n*3,n*4,n*6,n*8,n*12,s,s*2,s*3,s*4,s*5,s*6,s*7,s*8,s*9,s*10,s*15,r,r*2,r*3,r*4,r*6,o,o*2,o*5,o*10,o*25,o*50,o*100]),c=[[o,Rm,Ae,Ae,Ae,Ae,Ae,Ae,1],[s*28,"{MMM}",qp,Ae,Ae,Ae,Ae,Ae,1],[s,Cm,qp,Ae,Ae,Ae,Ae,Ae,1],[n,"{h}"+Pm,rl,Ae,zo,Ae,Ae,Ae,1],[e,Hr,rl,Ae,zo,Ae,Ae,Ae,1],[t,Yp,rl+" "+Hr,Ae,zo+" "+Hr,Ae,$p,Ae,1],[i,Yp+".{fff}",rl+" "+Hr,Ae,zo+" "+Hr,Ae,$p,Ae,1]];function h(f){return(u,d,g,M,m,p)=>{let y=[],A=m>=o,w=m>=r&&m<o,P=f(g),T=Oe(P*i,3),_=wu(P.getFullYear(),A?0:P.getMonth(),w||A?1:P.getDate()),E=Oe(_*i,3);if(w||A){let V=w?m/r:0,D=A?m/o:0,L=T==E?T:Oe(wu(_.getFullYear()+D,_.getMonth()+V,1)*i,3),H=new Date(_n(L/i)),G=H.getFullYear(),N=H.getMonth();for(let z=0;L<=M;z++){let J=wu(G+D*z,N+V*z,1),k=J-f(Oe(J*i,3));L=Oe((+J+k)*i,3),L<=M&&y.push(L)}}else{let V=m>=s?s:m,D=si(g)-si(T),L=E+D+dl(T-E,V);y.push(L);let H=f(L),G=H.getHours()+H.getMinutes()/e+H.getSeconds()/n,N=m/n,z=u.axes[d]._space,J=p/z;for(;L=Oe(L+m,i==1?0:3),!(L>M);)if(N>1){let k=si(Oe(G+N,6))%24,Q=f(L).getHours()-k;Q>1&&(Q=-1),L-=Q*n,G=(G+N)%24;let st=y[y.length-1];Oe((L-st)/m,3)*J>=.7&&y.push(L)}else y.push(L)}return y}}return[l,c,h]}var[sy,ry,oy]=Im(1),[ay,ly,cy]=Im(.001);Go(2,-53,53,[1]);function Zp(i,t){return i.map(e=>e.map((n,s)=>s==0||s==8||n==null?n:t(s==1||e[8]==0?n:e[1]+n)))}function Jp(i,t){return(e,n,s,r,o)=>{let a=t.find(g=>o>=g[0])||t[t.length-1],l,c,h,f,u,d;return n.map(g=>{let M=i(g),m=M.getFullYear(),p=M.getMonth(),y=M.getDate(),A=M.getHours(),w=M.getMinutes(),P=M.getSeconds(),T=m!=l&&a[2]||p!=c&&a[3]||y!=h&&a[4]||A!=f&&a[5]||w!=u&&a[6]||P!=d&&a[7]||a[1];return l=m,c=p,h=y,f=A,u=w,d=P,T(M)})}}function hy(i,t){let e=Wu(t);return(n,s,r,o,a)=>s.map(l=>e(i(l)))}function wu(i,t,e){return new Date(i,t,e)}function Kp(i,t){return t(i)}var uy="{YYYY}-{MM}-{DD} {h}:{mm}{aa}";function jp(i,t){return(e,n,s,r)=>r==null?Bu:t(i(n))}function fy(i,t){let e=i.series[t];return e.width?e.stroke(i,t):e.points.width?e.points.stroke(i,t):null}function dy(i,t){return i.series[t].fill(i,t)}var py={show:!0,live:!0,isolate:!1,mount:Nv,markers:{show:!0,width:2,stroke:fy,fill:dy,dash:"solid"},idx:null,idxs:null,values:[]};function my(i,t){let e=i.cursor.points,n=xi(),s=e.size(i,t);We(n,Bo,s),We(n,ko,s);let r=s/-2;We(n,"marginLeft",r),We(n,"marginTop",r);let o=e.width(i,t,s);return o&&We(n,"borderWidth",o),n}function gy(i,t){let e=i.series[t].points;return e._fill||e._stroke}function xy(i,t){let e=i.series[t].points;return e._stroke||e._fill}function _y(i,t){return i.series[t].points.size}var Eu=[0,0];function vy(i,t,e){return Eu[0]=t,Eu[1]=e,Eu}function ol(i,t,e,n=!0){return s=>{s.button==0&&(!n||s.target==t)&&e(s)}}function Tu(i,t,e,n=!0){return s=>{(!n||s.target==t)&&e(s)}}var yy={show:!0,x:!0,y:!0,lock:!1,move:vy,points:{one:!1,show:my,size:_y,width:0,stroke:xy,fill:gy},bind:{mousedown:ol,mouseup:ol,click:ol,dblclick:ol,mousemove:Tu,mouseleave:Tu,mouseenter:Tu},drag:{setScale:!0,x:!0,y:!1,dist:0,uni:null,click:(i,t)=>{t.stopPropagation(),t.stopImmediatePropagation()},_x:!1,_y:!1},focus:{dist:(i,t,e,n,s)=>n-s,prox:-1,bias:0},hover:{skip:[void 0],prox:null,bias:0},left:-10,top:-10,idx:null,dataIdx:null,idxs:null,event:null},Lm={show:!0,stroke:"rgba(0,0,0,0.07)",width:2},qu=dn({},Lm,{filter:_m}),Nm=dn({},qu,{size:10}),Dm=dn({},Lm,{show:!1}),$u='12px system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, "Noto Sans", sans-serif, "Apple Color Emoji", "Segoe UI Emoji", "Segoe UI Symbol", "Noto Color Emoji"',Um="bold "+$u,Fm=1.5,Qp={show:!0,scale:"x",stroke:Ou,space:50,gap:5,alignTo:1,size:50,labelGap:0,labelSize:30,labelFont:Um,side:2,grid:qu,ticks:Nm,border:Dm,font:$u,lineGap:Fm,rotate:0},by="Value",Sy="Time",tm={show:!0,scale:"x",auto:!1,sorted:1,min:Fe,max:-Fe,idxs:[]};function My(i,t,e,n,s){return t.map(r=>r==null?"":Hu(r))}function wy(i,t,e,n,s,r,o){let a=[],l=Ns.get(s)||0;e=o?e:Oe(dl(e,s),l);for(let c=e;c<=n;c=Oe(c+s,l))a.push(Object.is(c,-0)?0:c);return a}function Lu(i,t,e,n,s,r,o){let a=[],l=i.scales[i.axes[t].scale].log,c=l==10?as:mm,h=si(c(e));s=Wr(l,h),l==10&&(s=sr[Ti(s,sr)]);let f=e,u=s*l;l==10&&(u=sr[Ti(u,sr)]);do a.push(f),f=f+s,l==10&&!Ns.has(f)&&(f=Oe(f,Ns.get(s))),f>=u&&(s=f,u=s*l,l==10&&(u=sr[Ti(u,sr)]));while(f<=n);return a}function Ey(i,t,e,n,s,r,o){let l=i.scales[i.axes[t].scale].asinh,c=n>l?Lu(i,t,Xn(l,e),n,s):[l],h=n>=0&&e<=0?[0]:[];return(e<-l?Lu(i,t,Xn(l,-n),-e,s):[l]).reverse().map(u=>-u).concat(h,c)}var Om=/./,Ty=/[12357]/,Ay=/[125]/,em=/1/,Nu=(i,t,e,n)=>i.map((s,r)=>t==4&&s==0||r%n==0&&e.test(s.toExponential()[s<0?1:0])?s:null);function Ry(i,t,e,n,s){let r=i.axes[e],o=r.scale,a=i.scales[o],l=i.valToPos,c=r._space,h=l(10,o),f=l(9,o)-h>=c?Om:l(7,o)-h>=c?Ty:l(5,o)-h>=c?Ay:em;if(f==em){let u=vn(l(1,o)-h);if(u<c)return Nu(t.slice().reverse(),a.distr,f,_i(c/u)).reverse()}return Nu(t,a.distr,f,1)}function Cy(i,t,e,n,s){let r=i.axes[e],o=r.scale,a=r._space,l=i.valToPos,c=vn(l(1,o)-l(2,o));return c<a?Nu(t.slice().reverse(),3,Om,_i(a/c)).reverse():t}function Py(i,t,e,n){return n==null?Bu:t==null?"":Hu(t)}var nm={show:!0,scale:"y",stroke:Ou,space:30,gap:5,alignTo:1,size:50,labelGap:0,labelSize:30,labelFont:Um,side:3,grid:qu,ticks:Nm,border:Dm,font:$u,lineGap:Fm,rotate:0};function Iy(i,t){let e=3+(i||1)*2;return Oe(e*t,3)}function Ly(i,t){let{scale:e,idxs:n}=i.series[0],s=i._data[0],r=i.valToPos(s[n[0]],e,!0),o=i.valToPos(s[n[1]],e,!0),a=vn(o-r),l=i.series[t],c=a/(l.points.space*Te);return n[1]-n[0]<=c}var im={scale:null,auto:!0,sorted:0,min:Fe,max:-Fe},Bm=(i,t,e,n,s)=>s,sm={show:!0,auto:!0,sorted:0,gaps:Bm,alpha:1,facets:[dn({},im,{scale:"x"}),dn({},im,{scale:"y"})]},rm={scale:"y",auto:!0,sorted:0,show:!0,spanGaps:!1,gaps:Bm,alpha:1,points:{show:Ly,filter:null},values:null,min:Fe,max:-Fe,idxs:[],path:null,clip:null};function Ny(i,t,e,n,s){return e/10}var km={time:!0,auto:!0,distr:1,log:10,asinh:1,min:null,max:null,dir:1,ori:0},Dy=dn({},km,{time:!1,ori:1}),om={};function zm(i,t){let e=om[i];return e||(e={key:i,plots:[],sub(n){e.plots.push(n)},unsub(n){e.plots=e.plots.filter(s=>s!=n)},pub(n,s,r,o,a,l,c){for(let h=0;h<e.plots.length;h++)e.plots[h]!=s&&e.plots[h].pub(n,s,r,o,a,l,c)}},i!=null&&(om[i]=e)),e}var $r=1,Du=2;function lr(i,t,e){let n=i.mode,s=i.series[t],r=n==2?i._data[t]:i._data,o=i.scales,a=i.bbox,l=r[0],c=n==2?r[1]:r[t],h=n==2?o[s.facets[0].scale]:o[i.series[0].scale],f=n==2?o[s.facets[1].scale]:o[s.scale],u=a.left,d=a.top,g=a.width,M=a.height,m=i.valToPosH,p=i.valToPosV;return h.ori==0?e(s,l,c,h,f,m,p,u,d,g,M,gl,Zr,_l,Hm,Wm):e(s,l,c,h,f,p,m,d,u,M,g,xl,Jr,Ju,Gm,Xm)}function Yu(i,t){let e=0,n=0,s=Me(i.bands,Gu);for(let r=0;r<s.length;r++){let o=s[r];o.series[0]==t?e=o.dir:o.series[1]==t&&(o.dir==1?n|=1:n|=2)}return[e,n==1?-1:n==2?1:n==3?2:0]}function Uy(i,t,e,n,s){let r=i.mode,o=i.series[t],a=r==2?o.facets[1].scale:o.scale,l=i.scales[a];return s==-1?l.min:s==1?l.max:l.distr==3?l.dir==1?l.min:l.max:0}function ls(i,t,e,n,s,r){return lr(i,t,(o,a,l,c,h,f,u,d,g,M,m)=>{let p=o.pxRound,y=c.dir*(c.ori==0?1:-1),A=c.ori==0?Zr:Jr,w,P;y==1?(w=e,P=n):(w=n,P=e);let T=p(f(a[w],c,M,d)),_=p(u(l[w],h,m,g)),E=p(f(a[P],c,M,d)),V=p(u(r==1?h.max:h.min,h,m,g)),D=new Path2D(s);return A(D,E,V),A(D,T,V),A(D,T,_),D})}function ml(i,t,e,n,s,r){let o=null;if(i.length>0){o=new Path2D;let a=t==0?_l:Ju,l=e;for(let f=0;f<i.length;f++){let u=i[f];if(u[1]>u[0]){let d=u[0]-l;d>0&&a(o,l,n,d,n+r),l=u[1]}}let c=e+s-l,h=10;c>0&&a(o,l,n-h/2,c,n+r+h)}return o}function Fy(i,t,e){let n=i[i.length-1];n&&n[0]==t?n[1]=e:i.push([t,e])}function Zu(i,t,e,n,s,r,o){let a=[],l=i.length;for(let c=s==1?e:n;c>=e&&c<=n;c+=s)if(t[c]===null){let f=c,u=c;if(s==1)for(;++c<=n&&t[c]===null;)u=c;else for(;--c>=e&&t[c]===null;)u=c;let d=r(i[f]),g=u==f?d:r(i[u]),M=f-s;d=o<=0&&M>=0&&M<l?r(i[M]):d;let p=u+s;g=o>=0&&p>=0&&p<l?r(i[p]):g,g>=d&&a.push([d,g])}return a}function am(i){return i==0?xm:i==1?_n:t=>ir(t,i)}function Vm(i){let t=i==0?gl:xl,e=i==0?(s,r,o,a,l,c)=>{s.arcTo(r,o,a,l,c)}:(s,r,o,a,l,c)=>{s.arcTo(o,r,l,a,c)},n=i==0?(s,r,o,a,l)=>{s.rect(r,o,a,l)}:(s,r,o,a,l)=>{s.rect(o,r,l,a)};return(s,r,o,a,l,c=0,h=0)=>{c==0&&h==0?n(s,r,o,a,l):(c=Ai(c,a/2,l/2),h=Ai(h,a/2,l/2),t(s,r+c,o),e(s,r+a,o,r+a,o+l,c),e(s,r+a,o+l,r,o+l,h),e(s,r,o+l,r,o,h),e(s,r,o,r+a,o,c),s.closePath())}}var gl=(i,t,e)=>{i.moveTo(t,e)},xl=(i,t,e)=>{i.moveTo(e,t)},Zr=(i,t,e)=>{i.lineTo(t,e)},Jr=(i,t,e)=>{i.lineTo(e,t)},_l=Vm(0),Ju=Vm(1),Hm=(i,t,e,n,s,r)=>{i.arc(t,e,n,s,r)},Gm=(i,t,e,n,s,r)=>{i.arc(e,t,n,s,r)},Wm=(i,t,e,n,s,r,o)=>{i.bezierCurveTo(t,e,n,s,r,o)},Xm=(i,t,e,n,s,r,o)=>{i.bezierCurveTo(e,t,s,n,o,r)};function qm(i){return(t,e,n,s,r)=>lr(t,e,(o,a,l,c,h,f,u,d,g,M,m)=>{let{pxRound:p,points:y}=o,A,w;c.ori==0?(A=gl,w=Hm):(A=xl,w=Gm);let P=Oe(y.width*Te,3),T=(y.size-y.width)/2*Te,_=Oe(T*2,3),E=new Path2D,V=new Path2D,{left:D,top:L,width:H,height:G}=t.bbox;_l(V,D-_,L-_,H+_*2,G+_*2);let N=z=>{if(l[z]!=null){let J=p(f(a[z],c,M,d)),k=p(u(l[z],h,m,g));A(E,J+T,k),w(E,J,k,T,0,al*2)}};if(r)r.forEach(N);else for(let z=n;z<=s;z++)N(z);return{stroke:P>0?E:null,fill:E,clip:V,flags:$r|Du}})}function $m(i){return(t,e,n,s,r,o)=>{n!=s&&(r!=n&&o!=n&&i(t,e,n),r!=s&&o!=s&&i(t,e,s),i(t,e,o))}}var Oy=$m(Zr),By=$m(Jr);function Ym(i){let t=Me(i?.alignGaps,0);return(e,n,s,r)=>lr(e,n,(o,a,l,c,h,f,u,d,g,M,m)=>{[s,r]=ul(l,s,r);let p=o.pxRound,y=G=>p(f(G,c,M,d)),A=G=>p(u(G,h,m,g)),w,P;c.ori==0?(w=Zr,P=Oy):(w=Jr,P=By);let T=c.dir*(c.ori==0?1:-1),_={stroke:new Path2D,fill:null,clip:null,band:null,gaps:null,flags:$r},E=_.stroke,V=!1;if(r-s>=M*4){let G=ut=>e.posToVal(ut,c.key,!0),N=null,z=null,J,k,ct,K=y(a[T==1?s:r]),Q=y(a[s]),st=y(a[r]),ft=G(T==1?Q+1:st-1);for(let ut=T==1?s:r;ut>=s&&ut<=r;ut+=T){let tt=a[ut],_t=(T==1?tt<ft:tt>ft)?K:y(tt),At=l[ut];_t==K?At!=null?(k=At,N==null?(w(E,_t,A(k)),J=N=z=k):k<N?N=k:k>z&&(z=k)):At===null&&(V=!0):(N!=null&&P(E,K,A(N),A(z),A(J),A(k)),At!=null?(k=At,w(E,_t,A(k)),N=z=J=k):(N=z=null,At===null&&(V=!0)),K=_t,ft=G(K+T))}N!=null&&N!=z&&ct!=K&&P(E,K,A(N),A(z),A(J),A(k))}else for(let G=T==1?s:r;G>=s&&G<=r;G+=T){let N=l[G];N===null?V=!0:N!=null&&w(E,y(a[G]),A(N))}let[L,H]=Yu(e,n);if(o.fill!=null||L!=0){let G=_.fill=new Path2D(E),N=o.fillTo(e,n,o.min,o.max,L),z=A(N),J=y(a[s]),k=y(a[r]);T==-1&&([k,J]=[J,k]),w(G,k,z),w(G,J,z)}if(!o.spanGaps){let G=[];V&&G.push(...Zu(a,l,s,r,T,y,t)),_.gaps=G=o.gaps(e,n,s,r,G),_.clip=ml(G,c.ori,d,g,M,m)}return H!=0&&(_.band=H==2?[ls(e,n,s,r,E,-1),ls(e,n,s,r,E,1)]:ls(e,n,s,r,E,H)),_})}function ky(i){let t=Me(i.align,1),e=Me(i.ascDesc,!1),n=Me(i.alignGaps,0),s=Me(i.extend,!1);return(r,o,a,l)=>lr(r,o,(c,h,f,u,d,g,M,m,p,y,A)=>{[a,l]=ul(f,a,l);let w=c.pxRound,{left:P,width:T}=r.bbox,_=Q=>w(g(Q,u,y,m)),E=Q=>w(M(Q,d,A,p)),V=u.ori==0?Zr:Jr,D={stroke:new Path2D,fill:null,clip:null,band:null,gaps:null,flags:$r},L=D.stroke,H=u.dir*(u.ori==0?1:-1),G=E(f[H==1?a:l]),N=_(h[H==1?a:l]),z=N,J=N;s&&t==-1&&(J=P,V(L,J,G)),V(L,N,G);for(let Q=H==1?a:l;Q>=a&&Q<=l;Q+=H){let st=f[Q];if(st==null)continue;let ft=_(h[Q]),ut=E(st);t==1?V(L,ft,G):V(L,z,ut),V(L,ft,ut),G=ut,z=ft}let k=z;s&&t==1&&(k=P+T,V(L,k,G));let[ct,K]=Yu(r,o);if(c.fill!=null||ct!=0){let Q=D.fill=new Path2D(L),st=c.fillTo(r,o,c.min,c.max,ct),ft=E(st);V(Q,k,ft),V(Q,J,ft)}if(!c.spanGaps){let Q=[];Q.push(...Zu(h,f,a,l,H,_,n));let st=c.width*Te/2,ft=e||t==1?st:-st,ut=e||t==-1?-st:st;Q.forEach(tt=>{tt[0]+=ft,tt[1]+=ut}),D.gaps=Q=c.gaps(r,o,a,l,Q),D.clip=ml(Q,u.ori,m,p,y,A)}return K!=0&&(D.band=K==2?[ls(r,o,a,l,L,-1),ls(r,o,a,l,L,1)]:ls(r,o,a,l,L,K)),D})}function lm(i,t,e,n,s,r,o=Fe){if(i.length>1){let a=null;for(let l=0,c=1/0;l<i.length;l++)if(t[l]!==void 0){if(a!=null){let h=vn(i[l]-i[a]);h<c&&(c=h,o=vn(e(i[l],n,s,r)-e(i[a],n,s,r)))}a=l}}return o}function zy(i){i=i||Ho;let t=Me(i.size,[.6,Fe,1]),e=i.align||0,n=i.gap||0,s=i.radius;s=s==null?[0,0]:typeof s=="number"?[s,0]:s;let r=ve(s),o=1-t[0],a=Me(t[1],Fe),l=Me(t[2],1),c=Me(i.disp,Ho),h=Me(i.each,d=>{}),{fill:f,stroke:u}=c;return(d,g,M,m)=>lr(d,g,(p,y,A,w,P,T,_,E,V,D,L)=>{let H=p.pxRound,G=e,N=n*Te,z=a*Te,J=l*Te,k,ct;w.ori==0?[k,ct]=r(d,g):[ct,k]=r(d,g);let K=w.dir*(w.ori==0?1:-1),Q=w.ori==0?_l:Ju,st=w.ori==0?h:(Ct,Zt,ae,Mt,Ue,zt,$t)=>{h(Ct,Zt,ae,Ue,Mt,$t,zt)},ft=Me(d.bands,Gu).find(Ct=>Ct.series[0]==g),ut=ft!=null?ft.dir:0,tt=p.fillTo(d,g,p.min,p.max,ut),mt=H(_(tt,P,L,V)),_t,At,St,Wt=D,oe=H(p.width*Te),Vt=!1,de=null,he=null,se=null,$e=null;f!=null&&(oe==0||u!=null)&&(Vt=!0,de=f.values(d,g,M,m),he=new Map,new Set(de).forEach(Ct=>{Ct!=null&&he.set(Ct,new Path2D)}),oe>0&&(se=u.values(d,g,M,m),$e=new Map,new Set(se).forEach(Ct=>{Ct!=null&&$e.set(Ct,new Path2D)})));let{x0:Be,size:an}=c;if(Be!=null&&an!=null){G=1,y=Be.values(d,g,M,m),Be.unit==2&&(y=y.map(ae=>d.posToVal(E+ae*D,w.key,!0)));let Ct=an.values(d,g,M,m);an.unit==2?At=Ct[0]*D:At=T(Ct[0],w,D,E)-T(0,w,D,E),Wt=lm(y,A,T,w,D,E,Wt),St=Wt-At+N}else Wt=lm(y,A,T,w,D,E,Wt),St=Wt*o+N,At=Wt-St;St<1&&(St=0),oe>=At/2&&(oe=0),St<5&&(H=xm);let Le=St>0,Sn=Wt-St-(Le?oe:0);At=H(Iu(Sn,J,z)),_t=(G==0?At/2:G==K?0:At)-G*K*((G==0?N/2:0)+(Le?oe/2:0));let be={stroke:null,fill:null,clip:null,band:null,gaps:null,flags:0},gn=Vt?null:new Path2D,je=null;if(ft!=null)je=d.data[ft.series[1]];else{let{y0:Ct,y1:Zt}=c;Ct!=null&&Zt!=null&&(A=Zt.values(d,g,M,m),je=Ct.values(d,g,M,m))}let ln=k*At,F=ct*At;for(let Ct=K==1?M:m;Ct>=M&&Ct<=m;Ct+=K){let Zt=A[Ct];if(Zt==null)continue;if(je!=null){let W=je[Ct]??0;if(Zt-W==0)continue;mt=_(W,P,L,V)}let ae=w.distr!=2||c!=null?y[Ct]:Ct,Mt=T(ae,w,D,E),Ue=_(Me(Zt,tt),P,L,V),zt=H(Mt-_t),$t=H(Xn(Ue,mt)),R=H(Ai(Ue,mt)),v=$t-R;if(Zt!=null){let W=Zt<0?F:ln,ht=Zt<0?ln:F;Vt?(oe>0&&se[Ct]!=null&&Q($e.get(se[Ct]),zt,R+si(oe/2),At,Xn(0,v-oe),W,ht),de[Ct]!=null&&Q(he.get(de[Ct]),zt,R+si(oe/2),At,Xn(0,v-oe),W,ht)):Q(gn,zt,R+si(oe/2),At,Xn(0,v-oe),W,ht),st(d,g,Ct,zt-oe/2,R,At+oe,v)}}return oe>0?be.stroke=Vt?$e:gn:Vt||(be._fill=p.width==0?p._fill:p._stroke??p._fill,be.width=0),be.fill=Vt?he:gn,be})}function Vy(i,t){let e=Me(t?.alignGaps,0);return(n,s,r,o)=>lr(n,s,(a,l,c,h,f,u,d,g,M,m,p)=>{[r,o]=ul(c,r,o);let y=a.pxRound,A=k=>y(u(k,h,m,g)),w=k=>y(d(k,f,p,M)),P,T,_;h.ori==0?(P=gl,_=Zr,T=Wm):(P=xl,_=Jr,T=Xm);let E=h.dir*(h.ori==0?1:-1),V=A(l[E==1?r:o]),D=V,L=[],H=[];for(let k=E==1?r:o;k>=r&&k<=o;k+=E)if(c[k]!=null){let K=l[k],Q=A(K);L.push(D=Q),H.push(w(c[k]))}let G={stroke:i(L,H,P,_,T,y),fill:null,clip:null,band:null,gaps:null,flags:$r},N=G.stroke,[z,J]=Yu(n,s);if(a.fill!=null||z!=0){let k=G.fill=new Path2D(N),ct=a.fillTo(n,s,a.min,a.max,z),K=w(ct);_(k,D,K),_(k,V,K)}if(!a.spanGaps){let k=[];k.push(...Zu(l,c,r,o,E,A,e)),G.gaps=k=a.gaps(n,s,r,o,k),G.clip=ml(k,h.ori,g,M,m,p)}return J!=0&&(G.band=J==2?[ls(n,s,r,o,N,-1),ls(n,s,r,o,N,1)]:ls(n,s,r,o,N,J)),G})}function Hy(i){return Vy(Gy,i)}function Gy(i,t,e,n,s,r){let o=i.length;if(o<2)return null;let a=new Path2D;if(e(a,i[0],t[0]),o==2)n(a,i[1],t[1]);else{let l=Array(o),c=Array(o-1),h=Array(o-1),f=Array(o-1);for(let u=0;u<o-1;u++)h[u]=t[u+1]-t[u],f[u]=i[u+1]-i[u],c[u]=h[u]/f[u];l[0]=c[0];for(let u=1;u<o-1;u++)c[u]===0||c[u-1]===0||c[u-1]>0!=c[u]>0?l[u]=0:(l[u]=3*(f[u-1]+f[u])/((2*f[u]+f[u-1])/c[u-1]+(f[u]+2*f[u-1])/c[u]),isFinite(l[u])||(l[u]=0));l[o-1]=c[o-2];for(let u=0;u<o-1;u++)s(a,i[u]+f[u]/3,t[u]+l[u]*f[u]/3,i[u+1]-f[u]/3,t[u+1]-l[u+1]*f[u]/3,i[u+1],t[u+1])}return a}var Uu=new Set;function cm(){for(let i of Uu)i.syncRect(!0)}Yr&&(or(Mv,Gr,cm),or(wv,Gr,cm,!0),or(ll,Gr,()=>{In.pxRatio=Te}));var Wy=Ym(),Xy=qm();function hm(i,t,e,n){return(n?[i[0],i[1]].concat(i.slice(2)):[i[0]].concat(i.slice(1))).map((r,o)=>Fu(r,o,t,e))}function qy(i,t){return i.map((e,n)=>n==0?{}:dn({},t,e))}function Fu(i,t,e,n){return dn({},t==0?e:n,i)}function Zm(i,t,e){return t==null?Xr:[t,e]}var $y=Zm;function Yy(i,t,e){return t==null?Xr:cl(t,e,Vu,!0)}function Jm(i,t,e,n){return t==null?Xr:fl(t,e,i.scales[n].log,!1)}var Zy=Jm;function Km(i,t,e,n){return t==null?Xr:zu(t,e,i.scales[n].log,!1)}var Jy=Km;function Ky(i,t,e,n,s){let r=Xn(Hp(i),Hp(t)),o=t-i,a=Ti(s/n*o,e);do{let l=e[a],c=n*l/o;if(c>=s&&r+(l<5?Ns.get(l):0)<=17)return[l,c]}while(++a<e.length);return[0,0]}function um(i){let t,e;return i=i.replace(/(\d+)px/,(n,s)=>(t=_n((e=+s)*Te))+"px"),[i,t,e]}function jy(i){i.show&&[i.font,i.labelFont].forEach(t=>{let e=Oe(t[2]*Te,1);t[0]=t[0].replace(/[0-9.]+px/,e+"px"),t[1]=e})}function In(i,t,e){let n={mode:Me(i.mode,1)},s=n.mode;function r(x,b,C,I){let B=b.valToPct(x);return I+C*(b.dir==-1?1-B:B)}function o(x,b,C,I){let B=b.valToPct(x);return I+C*(b.dir==-1?B:1-B)}function a(x,b,C,I){return b.ori==0?r(x,b,C,I):o(x,b,C,I)}n.valToPosH=r,n.valToPosV=o;let l=!1;n.status=0;let c=n.root=xi(rv);if(i.id!=null&&(c.id=i.id),ii(c,i.class),i.title){let x=xi(lv,c);x.textContent=i.title}let h=Ei("canvas"),f=n.ctx=h.getContext("2d"),u=xi(cv,c);or("click",u,x=>{x.target===g&&(Ve!=Lr||Ye!=Nr)&&Pn.click(n,x)},!0);let d=n.under=xi(hv,u);u.appendChild(h);let g=n.over=xi(uv,u);i=qr(i);let M=+Me(i.pxAlign,1),m=am(M);(i.plugins||[]).forEach(x=>{x.opts&&(i=x.opts(n,i)||i)});let p=i.ms||.001,y=n.series=s==1?hm(i.series||[],tm,rm,!1):qy(i.series||[null],sm),A=n.axes=hm(i.axes||[],Qp,nm,!0),w=n.scales={},P=n.bands=i.bands||[];P.forEach(x=>{x.fill=ve(x.fill||null),x.dir=Me(x.dir,-1)});let T=s==2?y[1].facets[0].scale:y[0].scale,_={axes:rs,series:me},E=(i.drawOrder||["axes","series"]).map(x=>_[x]);function V(x){let b=x.distr==3?C=>as(C>0?C:x.clamp(n,C,x.min,x.max,x.key)):x.distr==4?C=>Mu(C,x.asinh):x.distr==100?C=>x.fwd(C):C=>C;return C=>{let I=b(C),{_min:B,_max:Z}=x,at=Z-B;return(I-B)/at}}function D(x){let b=w[x];if(b==null){let C=(i.scales||Ho)[x]||Ho;if(C.from!=null){D(C.from);let I=dn({},w[C.from],C,{key:x});I.valToPct=V(I),w[x]=I}else{b=w[x]=dn({},x==T?km:Dy,C),b.key=x;let I=b.time,B=b.range,Z=Ls(B);if((x!=T||s==2&&!I)&&(Z&&(B[0]==null||B[1]==null)&&(B={min:B[0]==null?kp:{mode:1,hard:B[0],soft:B[0]},max:B[1]==null?kp:{mode:1,hard:B[1],soft:B[1]}},Z=!1),!Z&&pl(B))){let at=B;B=(dt,yt,Nt)=>yt==null?Xr:cl(yt,Nt,at)}b.range=ve(B||(I?$y:x==T?b.distr==3?Zy:b.distr==4?Jy:Zm:b.distr==3?Jm:b.distr==4?Km:Yy)),b.auto=ve(Z?!1:b.auto),b.clamp=ve(b.clamp||Ny),b._min=b._max=null,b.valToPct=V(b)}}}D("x"),D("y"),s==1&&y.forEach(x=>{D(x.scale)}),A.forEach(x=>{D(x.scale)});for(let x in i.scales)D(x);let L=w[T],H=L.distr,G,N;L.ori==0?(ii(c,ov),G=r,N=o):(ii(c,av),G=o,N=r);let z={};for(let x in w){let b=w[x];(b.min!=null||b.max!=null)&&(z[x]={min:b.min,max:b.max},b.min=b.max=null)}let J=i.tzDate||(x=>new Date(_n(x/p))),k=i.fmtDate||Wu,ct=p==1?oy(J):cy(J),K=Jp(J,Zp(p==1?ry:ly,k)),Q=jp(J,Kp(uy,k)),st=[],ft=n.legend=dn({},py,i.legend),ut=n.cursor=dn({},yy,{drag:{y:s==2}},i.cursor),tt=ft.show,mt=ut.show,_t=ft.markers;ft.idxs=st,_t.width=ve(_t.width),_t.dash=ve(_t.dash),_t.stroke=ve(_t.stroke),_t.fill=ve(_t.fill);let At,St,Wt,oe=[],Vt=[],de,he=!1,se={};if(ft.live){let x=y[1]?y[1].values:null;he=x!=null,de=he?x(n,1,0):{_:0};for(let b in de)se[b]=Bu}if(tt)if(At=Ei("table",xv,c),Wt=Ei("tbody",null,At),ft.mount(n,At),he){St=Ei("thead",null,At,Wt);let x=Ei("tr",null,St);Ei("th",null,x);for(var $e in de)Ei("th",Tp,x).textContent=$e}else ii(At,vv),ft.live&&ii(At,_v);let Be={show:!0},an={show:!1};function Le(x,b){if(b==0&&(he||!ft.live||s==2))return Xr;let C=[],I=Ei("tr",yv,Wt,Wt.childNodes[b]);ii(I,x.class),x.show||ii(I,rr);let B=Ei("th",null,I);if(_t.show){let dt=xi(bv,B);if(b>0){let yt=_t.width(n,b);yt&&(dt.style.border=yt+"px "+_t.dash(n,b)+" "+_t.stroke(n,b)),dt.style.background=_t.fill(n,b)}}let Z=xi(Tp,B);x.label instanceof HTMLElement?Z.appendChild(x.label):Z.textContent=x.label,b>0&&(_t.show||(Z.style.color=x.width>0?_t.stroke(n,b):_t.fill(n,b)),be("click",B,dt=>{if(ut._lock)return;Qt(dt);let yt=y.indexOf(x);if((dt.ctrlKey||dt.metaKey)!=ft.isolate){let Nt=y.some((Dt,Ft)=>Ft>0&&Ft!=yt&&Dt.show);y.forEach((Dt,Ft)=>{Ft>0&&zi(Ft,Nt?Ft==yt?Be:an:Be,!0,fn.setSeries)})}else zi(yt,{show:!x.show},!0,fn.setSeries)},!1),te&&be(Pp,B,dt=>{ut._lock||(Qt(dt),zi(y.indexOf(x),Ur,!0,fn.setSeries))},!1));for(var at in de){let dt=Ei("td",Sv,I);dt.textContent="--",C.push(dt)}return[I,C]}let Sn=new Map;function be(x,b,C,I=!0){let B=Sn.get(b)||{},Z=ut.bind[x](n,b,C,I);Z&&(or(x,b,B[x]=Z),Sn.set(b,B))}function gn(x,b,C){let I=Sn.get(b)||{};for(let B in I)(x==null||B==x)&&(Pu(B,b,I[B]),delete I[B]);x==null&&Sn.delete(b)}let je=0,ln=0,F=0,Ct=0,Zt=0,ae=0,Mt=Zt,Ue=ae,zt=F,$t=Ct,R=0,v=0,W=0,ht=0;n.bbox={};let ot=!1,xt=!1,vt=!1,et=!1,it=!1,pt=!1;function U(x,b,C){(C||x!=n.width||b!=n.height)&&rt(x,b),ue(!1),vt=!0,xt=!0,Nn()}function rt(x,b){n.width=je=F=x,n.height=ln=Ct=b,Zt=ae=0,bt(),Ht();let C=n.bbox;R=C.left=ir(Zt*Te,.5),v=C.top=ir(ae*Te,.5),W=C.width=ir(F*Te,.5),ht=C.height=ir(Ct*Te,.5)}let nt=3;function wt(){let x=!1,b=0;for(;!x;){b++;let C=Cr(b),I=ki(b);x=b==nt||C&&I,x||(rt(n.width,n.height),xt=!0)}}function gt({width:x,height:b}){U(x,b)}n.setSize=gt;function bt(){let x=!1,b=!1,C=!1,I=!1;A.forEach((B,Z)=>{if(B.show&&B._show){let{side:at,_size:dt}=B,yt=at%2,Nt=B.label!=null?B.labelSize:0,Dt=dt+Nt;Dt>0&&(yt?(F-=Dt,at==3?(Zt+=Dt,I=!0):C=!0):(Ct-=Dt,at==0?(ae+=Dt,x=!0):b=!0))}}),Oi[0]=x,Oi[1]=C,Oi[2]=b,Oi[3]=I,F-=Si[1]+Si[3],Zt+=Si[3],Ct-=Si[2]+Si[0],ae+=Si[0]}function Ht(){let x=Zt+F,b=ae+Ct,C=Zt,I=ae;function B(Z,at){switch(Z){case 1:return x+=at,x-at;case 2:return b+=at,b-at;case 3:return C-=at,C+at;case 0:return I-=at,I+at}}A.forEach((Z,at)=>{if(Z.show&&Z._show){let dt=Z.side;Z._pos=B(dt,Z._size),Z.label!=null&&(Z._lpos=B(dt,Z.labelSize))}})}if(ut.dataIdx==null){let x=ut.hover,b=x.skip=new Set(x.skip??[]);b.add(void 0);let C=x.prox=ve(x.prox),I=x.bias??=0;ut.dataIdx=(B,Z,at,dt)=>{if(Z==0)return at;let yt=at,Nt=C(B,Z,at,dt)??Fe,Dt=Nt>=0&&Nt<Fe,Ft=L.ori==0?F:Ct,re=ut.left,Ee=t[0],Se=t[Z];if(b.has(Se[at])){yt=null;let xe=null,Kt=null,Xt;if(I==0||I==-1)for(Xt=at;xe==null&&Xt-- >0;)b.has(Se[Xt])||(xe=Xt);if(I==0||I==1)for(Xt=at;Kt==null&&Xt++<Se.length;)b.has(Se[Xt])||(Kt=Xt);if(xe!=null||Kt!=null)if(Dt){let Ge=xe==null?-1/0:G(Ee[xe],L,Ft,0),en=Kt==null?1/0:G(Ee[Kt],L,Ft,0),Tn=re-Ge,Ne=en-re;Tn<=Ne?Tn<=Nt&&(yt=xe):Ne<=Nt&&(yt=Kt)}else yt=Kt==null?xe:xe==null?Kt:at-xe<=Kt-at?xe:Kt}else Dt&&vn(re-G(Ee[at],L,Ft,0))>Nt&&(yt=null);return yt}}let Qt=x=>{ut.event=x};ut.idxs=st,ut._lock=!1;let lt=ut.points;lt.show=ve(lt.show),lt.size=ve(lt.size),lt.stroke=ve(lt.stroke),lt.width=ve(lt.width),lt.fill=ve(lt.fill);let Ot=n.focus=dn({},i.focus||{alpha:.3},ut.focus),te=Ot.prox>=0,Rt=te&&lt.one,ce=[],ze=[],kn=[];function Ao(x,b){let C=lt.show(n,b);if(C instanceof HTMLElement)return ii(C,gv),ii(C,x.class),qi(C,-10,-10,F,Ct),g.insertBefore(C,ce[b]),C}function Tr(x,b){if(s==1||b>0){let C=s==1&&w[x.scale].time,I=x.value;x.value=C?Xp(I)?jp(J,Kp(I,k)):I||Q:I||Py,x.label=x.label||(C?Sy:by)}if(Rt||b>0){x.width=x.width==null?1:x.width,x.paths=x.paths||Wy||Dv,x.fillTo=ve(x.fillTo||Uy),x.pxAlign=+Me(x.pxAlign,M),x.pxRound=am(x.pxAlign),x.stroke=ve(x.stroke||null),x.fill=ve(x.fill||null),x._stroke=x._fill=x._paths=x._focus=null;let C=Iy(Xn(1,x.width),1),I=x.points=dn({},{size:C,width:Xn(1,C*.2),stroke:x.stroke,space:C*2,paths:Xy,_stroke:null,_fill:null},x.points);I.show=ve(I.show),I.filter=ve(I.filter),I.fill=ve(I.fill),I.stroke=ve(I.stroke),I.paths=ve(I.paths),I.pxAlign=x.pxAlign}if(tt){let C=Le(x,b);oe.splice(b,0,C[0]),Vt.splice(b,0,C[1]),ft.values.push(null)}if(mt){st.splice(b,0,null);let C=null;Rt?b==0&&(C=Ao(x,b)):b>0&&(C=Ao(x,b)),ce.splice(b,0,C),ze.splice(b,0,0),kn.splice(b,0,0)}En("addSeries",b)}function jh(x,b){b=b??y.length,x=s==1?Fu(x,b,tm,rm):Fu(x,b,{},sm),y.splice(b,0,x),Tr(y[b],b)}n.addSeries=jh;function Ua(x){if(y.splice(x,1),tt){ft.values.splice(x,1),Vt.splice(x,1);let b=oe.splice(x,1)[0];gn(null,b.firstChild),b.remove()}mt&&(st.splice(x,1),ce.splice(x,1)[0].remove(),ze.splice(x,1),kn.splice(x,1)),En("delSeries",x)}n.delSeries=Ua;let Oi=[!1,!1,!1,!1];function ns(x,b){if(x._show=x.show,x.show){let C=x.side%2,I=w[x.scale];I==null&&(x.scale=C?y[1].scale:T,I=w[x.scale]);let B=I.time;x.size=ve(x.size),x.space=ve(x.space),x.rotate=ve(x.rotate),Ls(x.incrs)&&x.incrs.forEach(at=>{!Ns.has(at)&&Ns.set(at,ym(at))}),x.incrs=ve(x.incrs||(I.distr==2?ny:B?p==1?sy:ay:sr)),x.splits=ve(x.splits||(B&&I.distr==1?ct:I.distr==3?Lu:I.distr==4?Ey:wy)),x.stroke=ve(x.stroke),x.grid.stroke=ve(x.grid.stroke),x.ticks.stroke=ve(x.ticks.stroke),x.border.stroke=ve(x.border.stroke);let Z=x.values;x.values=Ls(Z)&&!Ls(Z[0])?ve(Z):B?Ls(Z)?Jp(J,Zp(Z,k)):Xp(Z)?hy(J,Z):Z||K:Z||My,x.filter=ve(x.filter||(I.distr>=3&&I.log==10?Ry:I.distr==3&&I.log==2?Cy:_m)),x.font=um(x.font),x.labelFont=um(x.labelFont),x._size=x.size(n,null,b,0),x._space=x._rotate=x._incrs=x._found=x._splits=x._values=null,x._size>0&&(Oi[b]=!0,x._el=xi(fv,u))}}function is(x,b,C,I){let[B,Z,at,dt]=C,yt=b%2,Nt=0;return yt==0&&(dt||Z)&&(Nt=b==0&&!B||b==2&&!at?_n(Qp.size/3):0),yt==1&&(B||at)&&(Nt=b==1&&!Z||b==3&&!dt?_n(nm.size/2):0),Nt}let Ro=n.padding=(i.padding||[is,is,is,is]).map(x=>ve(Me(x,is))),Si=n._padding=Ro.map((x,b)=>x(n,b,Oi,0)),Qe,sn=null,rn=null,Bi=s==1?y[0].idxs:null,Qn=null,Ss=!1;function Co(x,b){if(t=x??[],n.data=n._data=t,s==2){Qe=0;for(let C=1;C<y.length;C++)Qe+=t[C][0].length}else{t.length==0&&(n.data=n._data=t=[[]]),Qn=t[0],Qe=Qn.length;let C=t;if(H==2){C=t.slice();let I=C[0]=Array(Qe);for(let B=0;B<Qe;B++)I[B]=B}n._data=t=C}if(ue(!0),En("setData"),H==2&&(vt=!0),b!==!1){let C=L;C.auto(n,Ss)?Po():Es(T,C.min,C.max),et=et||ut.left>=0,pt=!0,Nn()}}n.setData=Co;function Po(){Ss=!0;let x,b;s==1&&(Qe>0?(sn=Bi[0]=0,rn=Bi[1]=Qe-1,x=t[0][sn],b=t[0][rn],H==2?(x=sn,b=rn):x==b&&(H==3?[x,b]=fl(x,x,L.log,!1):H==4?[x,b]=zu(x,x,L.log,!1):L.time?b=x+_n(86400/p):[x,b]=cl(x,b,Vu,!0))):(sn=Bi[0]=x=null,rn=Bi[1]=b=null)),Es(T,x,b)}let Ar,Ms,Rr,S,O,j,$,Y,Et,Pt;function Tt(x,b,C,I,B,Z){x??=Rp,C??=Gu,I??="butt",B??=Rp,Z??="round",x!=Ar&&(f.strokeStyle=Ar=x),B!=Ms&&(f.fillStyle=Ms=B),b!=Rr&&(f.lineWidth=Rr=b),Z!=O&&(f.lineJoin=O=Z),I!=j&&(f.lineCap=j=I),C!=S&&f.setLineDash(S=C)}function It(x,b,C,I){b!=Ms&&(f.fillStyle=Ms=b),x!=$&&(f.font=$=x),C!=Y&&(f.textAlign=Y=C),I!=Et&&(f.textBaseline=Et=I)}function kt(x,b,C,I,B=0){if(I.length>0&&x.auto(n,Ss)&&(b==null||b.min==null)){let Z=Me(sn,0),at=Me(rn,I.length-1),dt=C.min==null?Rv(I,Z,at,B,x.distr==3):[C.min,C.max];x.min=Ai(x.min,C.min=dt[0]),x.max=Xn(x.max,C.max=dt[1])}}let ee={min:null,max:null};function pe(){for(let I in w){let B=w[I];z[I]==null&&(B.min==null||z[T]!=null&&B.auto(n,Ss))&&(z[I]=ee)}for(let I in w){let B=w[I];z[I]==null&&B.from!=null&&z[B.from]!=null&&(z[I]=ee)}z[T]!=null&&ue(!0);let x={};for(let I in z){let B=z[I];if(B!=null){let Z=x[I]=qr(w[I],Ov);if(B.min!=null)dn(Z,B);else if(I!=T||s==2)if(Qe==0&&Z.from==null){let at=Z.range(n,null,null,I);Z.min=at[0],Z.max=at[1]}else Z.min=Fe,Z.max=-Fe}}if(Qe>0){y.forEach((I,B)=>{if(s==1){let Z=I.scale,at=z[Z];if(at==null)return;let dt=x[Z];if(B==0){let yt=dt.range(n,dt.min,dt.max,Z);dt.min=yt[0],dt.max=yt[1],sn=Ti(dt.min,t[0]),rn=Ti(dt.max,t[0]),rn-sn>1&&(t[0][sn]<dt.min&&sn++,t[0][rn]>dt.max&&rn--),I.min=Qn[sn],I.max=Qn[rn]}else I.show&&I.auto&&kt(dt,at,I,t[B],I.sorted);I.idxs[0]=sn,I.idxs[1]=rn}else if(B>0&&I.show&&I.auto){let[Z,at]=I.facets,dt=Z.scale,yt=at.scale,[Nt,Dt]=t[B],Ft=x[dt],re=x[yt];Ft!=null&&kt(Ft,z[dt],Z,Nt,Z.sorted),re!=null&&kt(re,z[yt],at,Dt,at.sorted),I.min=at.min,I.max=at.max}});for(let I in x){let B=x[I],Z=z[I];if(B.from==null&&(Z==null||Z.min==null)){let at=B.range(n,B.min==Fe?null:B.min,B.max==-Fe?null:B.max,I);B.min=at[0],B.max=at[1]}}}for(let I in x){let B=x[I];if(B.from!=null){let Z=x[B.from];if(Z.min==null)B.min=B.max=null;else{let at=B.range(n,Z.min,Z.max,I);B.min=at[0],B.max=at[1]}}}let b={},C=!1;for(let I in x){let B=x[I],Z=w[I];if(Z.min!=B.min||Z.max!=B.max){Z.min=B.min,Z.max=B.max;let at=Z.distr;Z._min=at==3?as(Z.min):at==4?Mu(Z.min,Z.asinh):at==100?Z.fwd(Z.min):Z.min,Z._max=at==3?as(Z.max):at==4?Mu(Z.max,Z.asinh):at==100?Z.fwd(Z.max):Z.max,b[I]=C=!0}}if(C){y.forEach((I,B)=>{s==2?B>0&&b.y&&(I._paths=null):b[I.scale]&&(I._paths=null)});for(let I in b)vt=!0,En("setScale",I);mt&&ut.left>=0&&(et=pt=!0)}for(let I in z)z[I]=null}function Bt(x){let b=Iu(sn-1,0,Qe-1),C=Iu(rn+1,0,Qe-1);for(;x[b]==null&&b>0;)b--;for(;x[C]==null&&C<Qe-1;)C++;return[b,C]}function me(){if(Qe>0){let x=y.some(b=>b._focus)&&Pt!=Ot.alpha;x&&(f.globalAlpha=Pt=Ot.alpha),y.forEach((b,C)=>{if(C>0&&b.show&&(Je(C,!1),Je(C,!0),b._paths==null)){let I=Pt;Pt!=b.alpha&&(f.globalAlpha=Pt=b.alpha);let B=s==2?[0,t[C][0].length-1]:Bt(t[C]);b._paths=b.paths(n,C,B[0],B[1]),Pt!=I&&(f.globalAlpha=Pt=I)}}),y.forEach((b,C)=>{if(C>0&&b.show){let I=Pt;Pt!=b.alpha&&(f.globalAlpha=Pt=b.alpha),b._paths!=null&&Ce(C,!1);{let B=b._paths!=null?b._paths.gaps:null,Z=b.points.show(n,C,sn,rn,B),at=b.points.filter(n,C,Z,B);(Z||at)&&(b.points._paths=b.points.paths(n,C,sn,rn,at),Ce(C,!0))}Pt!=I&&(f.globalAlpha=Pt=I),En("drawSeries",C)}}),x&&(f.globalAlpha=Pt=1)}}function Je(x,b){let C=b?y[x].points:y[x];C._stroke=C.stroke(n,x),C._fill=C.fill(n,x)}function Ce(x,b){let C=b?y[x].points:y[x],{stroke:I,fill:B,clip:Z,flags:at,_stroke:dt=C._stroke,_fill:yt=C._fill,_width:Nt=C.width}=C._paths;Nt=Oe(Nt*Te,3);let Dt=null,Ft=Nt%2/2;b&&yt==null&&(yt=Nt>0?"#fff":dt);let re=C.pxAlign==1&&Ft>0;if(re&&f.translate(Ft,Ft),!b){let Ee=R-Nt/2,Se=v-Nt/2,xe=W+Nt,Kt=ht+Nt;Dt=new Path2D,Dt.rect(Ee,Se,xe,Kt)}b?Ut(dt,Nt,C.dash,C.cap,yt,I,B,at,Z):Pe(x,dt,Nt,C.dash,C.cap,yt,I,B,at,Dt,Z),re&&f.translate(-Ft,-Ft)}function Pe(x,b,C,I,B,Z,at,dt,yt,Nt,Dt){let Ft=!1;yt!=0&&P.forEach((re,Ee)=>{if(re.series[0]==x){let Se=y[re.series[1]],xe=t[re.series[1]],Kt=(Se._paths||Ho).band;Ls(Kt)&&(Kt=re.dir==1?Kt[0]:Kt[1]);let Xt,Ge=null;Se.show&&Kt&&Pv(xe,sn,rn)?(Ge=re.fill(n,Ee)||Z,Xt=Se._paths.clip):Kt=null,Ut(b,C,I,B,Ge,at,dt,yt,Nt,Dt,Xt,Kt),Ft=!0}}),Ft||Ut(b,C,I,B,Z,at,dt,yt,Nt,Dt)}let xn=$r|Du;function Ut(x,b,C,I,B,Z,at,dt,yt,Nt,Dt,Ft){Tt(x,b,C,I,B),(yt||Nt||Ft)&&(f.save(),yt&&f.clip(yt),Nt&&f.clip(Nt)),Ft?(dt&xn)==xn?(f.clip(Ft),Dt&&f.clip(Dt),_e(B,at),cn(x,Z,b)):dt&Du?(_e(B,at),f.clip(Ft),cn(x,Z,b)):dt&$r&&(f.save(),f.clip(Ft),Dt&&f.clip(Dt),_e(B,at),f.restore(),cn(x,Z,b)):(_e(B,at),cn(x,Z,b)),(yt||Nt||Ft)&&f.restore()}function cn(x,b,C){C>0&&(b instanceof Map?b.forEach((I,B)=>{f.strokeStyle=Ar=B,f.stroke(I)}):b!=null&&x&&f.stroke(b))}function _e(x,b){b instanceof Map?b.forEach((C,I)=>{f.fillStyle=Ms=I,f.fill(C)}):b!=null&&x&&f.fill(b)}function ss(x,b,C,I){let B=A[x],Z;if(I<=0)Z=[0,0];else{let at=B._space=B.space(n,x,b,C,I),dt=B._incrs=B.incrs(n,x,b,C,I,at);Z=Ky(b,C,dt,I,at)}return B._found=Z}function hn(x,b,C,I,B,Z,at,dt,yt,Nt){let Dt=at%2/2;M==1&&f.translate(Dt,Dt),Tt(dt,at,yt,Nt,dt),f.beginPath();let Ft,re,Ee,Se,xe=B+(I==0||I==3?-Z:Z);C==0?(re=B,Se=xe):(Ft=B,Ee=xe);for(let Kt=0;Kt<x.length;Kt++)b[Kt]!=null&&(C==0?Ft=Ee=x[Kt]:re=Se=x[Kt],f.moveTo(Ft,re),f.lineTo(Ee,Se));f.stroke(),M==1&&f.translate(-Dt,-Dt)}function Cr(x){let b=!0;return A.forEach((C,I)=>{if(!C.show)return;let B=w[C.scale];if(B.min==null){C._show&&(b=!1,C._show=!1,ue(!1));return}else C._show||(b=!1,C._show=!0,ue(!1));let Z=C.side,at=Z%2,{min:dt,max:yt}=B,[Nt,Dt]=ss(I,dt,yt,at==0?F:Ct);if(Dt==0)return;let Ft=B.distr==2,re=C._splits=C.splits(n,I,dt,yt,Nt,Dt,Ft),Ee=B.distr==2?re.map(Xt=>Qn[Xt]):re,Se=B.distr==2?Qn[re[1]]-Qn[re[0]]:Nt,xe=C._values=C.values(n,C.filter(n,Ee,I,Dt,Se),I,Dt,Se);C._rotate=Z==2?C.rotate(n,xe,I,Dt):0;let Kt=C._size;C._size=_i(C.size(n,xe,I,x)),Kt!=null&&C._size!=Kt&&(b=!1)}),b}function ki(x){let b=!0;return Ro.forEach((C,I)=>{let B=C(n,I,Oi,x);B!=Si[I]&&(b=!1),Si[I]=B}),b}function rs(){for(let x=0;x<A.length;x++){let b=A[x];if(!b.show||!b._show)continue;let C=b.side,I=C%2,B,Z,at=b.stroke(n,x),dt=C==0||C==3?-1:1,[yt,Nt]=b._found;if(b.label!=null){let Hn=b.labelGap*dt,ni=_n((b._lpos+Hn)*Te);It(b.labelFont[0],at,"center",C==2?"top":Ap),f.save(),I==1?(B=Z=0,f.translate(ni,_n(v+ht/2)),f.rotate((C==3?-al:al)/2)):(B=_n(R+W/2),Z=ni);let Qs=gm(b.label)?b.label(n,x,yt,Nt):b.label;f.fillText(Qs,B,Z),f.restore()}if(Nt==0)continue;let Dt=w[b.scale],Ft=I==0?W:ht,re=I==0?R:v,Ee=b._splits,Se=Dt.distr==2?Ee.map(Hn=>Qn[Hn]):Ee,xe=Dt.distr==2?Qn[Ee[1]]-Qn[Ee[0]]:yt,Kt=b.ticks,Xt=b.border,Ge=Kt.show?Kt.size:0,en=_n(Ge*Te),Tn=_n((b.alignTo==2?b._size-Ge-b.gap:b.gap)*Te),Ne=b._rotate*-al/180,nn=m(b._pos*Te),ti=(en+Tn)*dt,Vn=nn+ti;Z=I==0?Vn:0,B=I==1?Vn:0;let pi=b.font[0],Mi=b.align==1?Vr:b.align==2?yu:Ne>0?Vr:Ne<0?yu:I==0?"center":C==3?yu:Vr,Hi=Ne||I==1?"middle":C==2?"top":Ap;It(pi,at,Mi,Hi);let ei=b.font[1]*b.lineGap,mi=Ee.map(Hn=>m(a(Hn,Dt,Ft,re))),wi=b._values;for(let Hn=0;Hn<wi.length;Hn++){let ni=wi[Hn];if(ni!=null){I==0?B=mi[Hn]:Z=mi[Hn],ni=""+ni;let Qs=ni.indexOf(`
`)==-1?[ni]:ni.split(/\n/gm);for(let Gn=0;Gn<Qs.length;Gn++){let ip=Qs[Gn];Ne?(f.save(),f.translate(B,Z+Gn*ei),f.rotate(Ne),f.fillText(ip,0,0),f.restore()):f.fillText(ip,B,Z+Gn*ei)}}}Kt.show&&hn(mi,Kt.filter(n,Se,x,Nt,xe),I,C,nn,en,Oe(Kt.width*Te,3),Kt.stroke(n,x),Kt.dash,Kt.cap);let Gi=b.grid;Gi.show&&hn(mi,Gi.filter(n,Se,x,Nt,xe),I,I==0?2:1,I==0?v:R,I==0?ht:W,Oe(Gi.width*Te,3),Gi.stroke(n,x),Gi.dash,Gi.cap),Xt.show&&hn([nn],[1],I==0?1:0,I==0?1:2,I==1?v:R,I==1?ht:W,Oe(Xt.width*Te,3),Xt.stroke(n,x),Xt.dash,Xt.cap)}En("drawAxes")}function ue(x){y.forEach((b,C)=>{C>0&&(b._paths=null,x&&(s==1?(b.min=null,b.max=null):b.facets.forEach(I=>{I.min=null,I.max=null})))})}let tn=!1,zn=!1,Ie=[];function un(){zn=!1;for(let x=0;x<Ie.length;x++)En(...Ie[x]);Ie.length=0}function Nn(){tn||(Wv(kd),tn=!0)}function Fa(x,b=!1){tn=!0,zn=b,x(n),kd(),b&&Ie.length>0&&queueMicrotask(un)}n.batch=Fa;function kd(){if(ot&&(pe(),ot=!1),vt&&(wt(),vt=!1),xt){if(We(d,Vr,Zt),We(d,"top",ae),We(d,Bo,F),We(d,ko,Ct),We(g,Vr,Zt),We(g,"top",ae),We(g,Bo,F),We(g,ko,Ct),We(u,Bo,je),We(u,ko,ln),h.width=_n(je*Te),h.height=_n(ln*Te),A.forEach(({_el:x,_show:b,_size:C,_pos:I,side:B})=>{if(x!=null)if(b){let Z=B===3||B===0?C:0,at=B%2==1;We(x,at?"left":"top",I-Z),We(x,at?"width":"height",C),We(x,at?"top":"left",at?ae:Zt),We(x,at?"height":"width",at?Ct:F),Cu(x,rr)}else ii(x,rr)}),Ar=Ms=Rr=O=j=$=Y=Et=S=null,Pt=1,No(!0),Zt!=Mt||ae!=Ue||F!=zt||Ct!=$t){ue(!1);let x=F/zt,b=Ct/$t;if(mt&&!et&&ut.left>=0){ut.left*=x,ut.top*=b,Pr&&qi(Pr,_n(ut.left),0,F,Ct),Ir&&qi(Ir,0,_n(ut.top),F,Ct);for(let C=0;C<ce.length;C++){let I=ce[C];I!=null&&(ze[C]*=x,kn[C]*=b,qi(I,_i(ze[C]),_i(kn[C]),F,Ct))}}if(He.show&&!it&&He.left>=0&&He.width>0){He.left*=x,He.width*=x,He.top*=b,He.height*=b;for(let C in su)We(Dr,C,He[C])}Mt=Zt,Ue=ae,zt=F,$t=Ct}En("setSize"),xt=!1}je>0&&ln>0&&(f.clearRect(0,0,h.width,h.height),En("drawClear"),E.forEach(x=>x()),En("draw")),He.show&&it&&(Oa(He),it=!1),mt&&et&&(js(null,!0,!1),et=!1),ft.show&&ft.live&&pt&&(nu(),pt=!1),l||(l=!0,n.status=1,En("ready")),Ss=!1,tn=!1}n.redraw=(x,b)=>{vt=b||!1,x!==!1?Es(T,L.min,L.max):Nn()};function Qh(x,b){let C=w[x];if(C.from==null){if(Qe==0){let I=C.range(n,b.min,b.max,x);b.min=I[0],b.max=I[1]}if(b.min>b.max){let I=b.min;b.min=b.max,b.max=I}if(Qe>1&&b.min!=null&&b.max!=null&&b.max-b.min<1e-16)return;x==T&&C.distr==2&&Qe>0&&(b.min=Ti(b.min,t[0]),b.max=Ti(b.max,t[0]),b.min==b.max&&b.max++),z[x]=b,ot=!0,Nn()}}n.setScale=Qh;let tu,eu,Pr,Ir,zd,Vd,Lr,Nr,Hd,Gd,Ve,Ye,ws=!1,Pn=ut.drag,Mn=Pn.x,wn=Pn.y;mt&&(ut.x&&(tu=xi(pv,g)),ut.y&&(eu=xi(mv,g)),L.ori==0?(Pr=tu,Ir=eu):(Pr=eu,Ir=tu),Ve=ut.left,Ye=ut.top);let He=n.select=dn({show:!0,over:!0,left:0,width:0,top:0,height:0},i.select),Dr=He.show?xi(dv,He.over?g:d):null;function Oa(x,b){if(He.show){for(let C in x)He[C]=x[C],C in su&&We(Dr,C,x[C]);b!==!1&&En("setSelect")}}n.setSelect=Oa;function u_(x){if(y[x].show)tt&&Cu(oe[x],rr);else if(tt&&ii(oe[x],rr),mt){let C=Rt?ce[0]:ce[x];C!=null&&qi(C,-10,-10,F,Ct)}}function Es(x,b,C){Qh(x,{min:b,max:C})}function zi(x,b,C,I){b.focus!=null&&g_(x),b.show!=null&&y.forEach((B,Z)=>{Z>0&&(x==Z||x==null)&&(B.show=b.show,u_(Z),s==2?(Es(B.facets[0].scale,null,null),Es(B.facets[1].scale,null,null)):Es(B.scale,null,null),Nn())}),C!==!1&&En("setSeries",x,b),I&&Do("setSeries",n,x,b)}n.setSeries=zi;function f_(x,b){dn(P[x],b)}function d_(x,b){x.fill=ve(x.fill||null),x.dir=Me(x.dir,-1),b=b??P.length,P.splice(b,0,x)}function p_(x){x==null?P.length=0:P.splice(x,1)}n.addBand=d_,n.setBand=f_,n.delBand=p_;function m_(x,b){y[x].alpha=b,mt&&ce[x]!=null&&(ce[x].style.opacity=b),tt&&oe[x]&&(oe[x].style.opacity=b)}let os,Ts,Ks,Ur={focus:!0};function g_(x){if(x!=Ks){let b=x==null,C=Ot.alpha!=1;y.forEach((I,B)=>{if(s==1||B>0){let Z=b||B==0||B==x;I._focus=b?null:Z,C&&m_(B,Z?1:Ot.alpha)}}),Ks=x,C&&Nn()}}tt&&te&&be(Ip,At,x=>{ut._lock||(Qt(x),Ks!=null&&zi(null,Ur,!0,fn.setSeries))});function Vi(x,b,C){let I=w[b];C&&(x=x/Te-(I.ori==1?ae:Zt));let B=F;I.ori==1&&(B=Ct,x=B-x),I.dir==-1&&(x=B-x);let Z=I._min,at=I._max,dt=x/B,yt=Z+(at-Z)*dt,Nt=I.distr;return Nt==3?Wr(10,yt):Nt==4?Lv(yt,I.asinh):Nt==100?I.bwd(yt):yt}function x_(x,b){let C=Vi(x,T,b);return Ti(C,t[0],sn,rn)}n.valToIdx=x=>Ti(x,t[0]),n.posToIdx=x_,n.posToVal=Vi,n.valToPos=(x,b,C)=>w[b].ori==0?r(x,w[b],C?W:F,C?R:0):o(x,w[b],C?ht:Ct,C?v:0),n.setCursor=(x,b,C)=>{Ve=x.left,Ye=x.top,js(null,b,C)};function Wd(x,b){We(Dr,Vr,He.left=x),We(Dr,Bo,He.width=b)}function Xd(x,b){We(Dr,"top",He.top=x),We(Dr,ko,He.height=b)}let Io=L.ori==0?Wd:Xd,Lo=L.ori==1?Wd:Xd;function __(){if(tt&&ft.live)for(let x=s==2?1:0;x<y.length;x++){if(x==0&&he)continue;let b=ft.values[x],C=0;for(let I in b)Vt[x][C++].firstChild.nodeValue=b[I]}}function nu(x,b){if(x!=null&&(x.idxs?x.idxs.forEach((C,I)=>{st[I]=C}):Fv(x.idx)||st.fill(x.idx),ft.idx=st[0]),tt&&ft.live){for(let C=0;C<y.length;C++)(C>0||s==1&&!he)&&v_(C,st[C]);__()}pt=!1,b!==!1&&En("setLegend")}n.setLegend=nu;function v_(x,b){let C=y[x],I=x==0&&H==2?Qn:t[x],B;he?B=C.values(n,x,b)??se:(B=C.value(n,b==null?null:I[b],x,b),B=B==null?se:{_:B}),ft.values[x]=B}function js(x,b,C){Hd=Ve,Gd=Ye,[Ve,Ye]=ut.move(n,Ve,Ye),ut.left=Ve,ut.top=Ye,mt&&(Pr&&qi(Pr,_n(Ve),0,F,Ct),Ir&&qi(Ir,0,_n(Ye),F,Ct));let I,B=sn>rn;os=Fe,Ts=null;let Z=L.ori==0?F:Ct,at=L.ori==1?F:Ct;if(Ve<0||Qe==0||B){I=ut.idx=null;for(let dt=0;dt<y.length;dt++){let yt=ce[dt];yt!=null&&qi(yt,-10,-10,F,Ct)}te&&zi(null,Ur,!0,x==null&&fn.setSeries),ft.live&&(st.fill(I),pt=!0)}else{let dt,yt,Nt;s==1&&(dt=L.ori==0?Ve:Ye,yt=Vi(dt,T),I=ut.idx=Ti(yt,t[0],sn,rn),Nt=G(t[0][I],L,Z,0));let Dt=-10,Ft=-10,re=0,Ee=0,Se=!0,xe="",Kt="";for(let Xt=s==2?1:0;Xt<y.length;Xt++){let Ge=y[Xt],en=st[Xt],Tn=en==null?null:s==1?t[Xt][en]:t[Xt][1][en],Ne=ut.dataIdx(n,Xt,I,yt),nn=Ne==null?null:s==1?t[Xt][Ne]:t[Xt][1][Ne];if(pt=pt||nn!=Tn||Ne!=en,st[Xt]=Ne,Xt>0&&Ge.show){let ti=Ne==null?-10:Ne==I?Nt:G(s==1?t[0][Ne]:t[Xt][0][Ne],L,Z,0),Vn=nn==null?-10:N(nn,s==1?w[Ge.scale]:w[Ge.facets[1].scale],at,0);if(te&&nn!=null){let pi=L.ori==1?Ve:Ye,Mi=vn(Ot.dist(n,Xt,Ne,Vn,pi));if(Mi<os){let Hi=Ot.bias;if(Hi!=0){let ei=Vi(pi,Ge.scale),mi=nn>=0?1:-1,wi=ei>=0?1:-1;wi==mi&&(wi==1?Hi==1?nn>=ei:nn<=ei:Hi==1?nn<=ei:nn>=ei)&&(os=Mi,Ts=Xt)}else os=Mi,Ts=Xt}}if(pt||Rt){let pi,Mi;L.ori==0?(pi=ti,Mi=Vn):(pi=Vn,Mi=ti);let Hi,ei,mi,wi,Gi,Hn,ni=!0,Qs=lt.bbox;if(Qs!=null){ni=!1;let Gn=Qs(n,Xt);mi=Gn.left,wi=Gn.top,Hi=Gn.width,ei=Gn.height}else mi=pi,wi=Mi,Hi=ei=lt.size(n,Xt);if(Hn=lt.fill(n,Xt),Gi=lt.stroke(n,Xt),Rt)Xt==Ts&&os<=Ot.prox&&(Dt=mi,Ft=wi,re=Hi,Ee=ei,Se=ni,xe=Hn,Kt=Gi);else{let Gn=ce[Xt];Gn!=null&&(ze[Xt]=mi,kn[Xt]=wi,Bp(Gn,Hi,ei,ni),Fp(Gn,Hn,Gi),qi(Gn,_i(mi),_i(wi),F,Ct))}}}}if(Rt){let Xt=Ot.prox,Ge=Ks==null?os<=Xt:os>Xt||Ts!=Ks;if(pt||Ge){let en=ce[0];en!=null&&(ze[0]=Dt,kn[0]=Ft,Bp(en,re,Ee,Se),Fp(en,xe,Kt),qi(en,_i(Dt),_i(Ft),F,Ct))}}}if(He.show&&ws)if(x!=null){let[dt,yt]=fn.scales,[Nt,Dt]=fn.match,[Ft,re]=x.cursor.sync.scales,Ee=x.cursor.drag;if(Mn=Ee._x,wn=Ee._y,Mn||wn){let{left:Se,top:xe,width:Kt,height:Xt}=x.select,Ge=x.scales[Ft].ori,en=x.posToVal,Tn,Ne,nn,ti,Vn,pi=dt!=null&&Nt(dt,Ft),Mi=yt!=null&&Dt(yt,re);pi&&Mn?(Ge==0?(Tn=Se,Ne=Kt):(Tn=xe,Ne=Xt),nn=w[dt],ti=G(en(Tn,Ft),nn,Z,0),Vn=G(en(Tn+Ne,Ft),nn,Z,0),Io(Ai(ti,Vn),vn(Vn-ti))):Io(0,Z),Mi&&wn?(Ge==1?(Tn=Se,Ne=Kt):(Tn=xe,Ne=Xt),nn=w[yt],ti=N(en(Tn,re),nn,at,0),Vn=N(en(Tn+Ne,re),nn,at,0),Lo(Ai(ti,Vn),vn(Vn-ti))):Lo(0,at)}else ru()}else{let dt=vn(Hd-zd),yt=vn(Gd-Vd);if(L.ori==1){let re=dt;dt=yt,yt=re}Mn=Pn.x&&dt>=Pn.dist,wn=Pn.y&&yt>=Pn.dist;let Nt=Pn.uni;Nt!=null?Mn&&wn&&(Mn=dt>=Nt,wn=yt>=Nt,!Mn&&!wn&&(yt>dt?wn=!0:Mn=!0)):Pn.x&&Pn.y&&(Mn||wn)&&(Mn=wn=!0);let Dt,Ft;Mn&&(L.ori==0?(Dt=Lr,Ft=Ve):(Dt=Nr,Ft=Ye),Io(Ai(Dt,Ft),vn(Ft-Dt)),wn||Lo(0,at)),wn&&(L.ori==1?(Dt=Lr,Ft=Ve):(Dt=Nr,Ft=Ye),Lo(Ai(Dt,Ft),vn(Ft-Dt)),Mn||Io(0,Z)),!Mn&&!wn&&(Io(0,0),Lo(0,0))}if(Pn._x=Mn,Pn._y=wn,x==null){if(C){if(np!=null){let[dt,yt]=fn.scales;fn.values[0]=dt!=null?Vi(L.ori==0?Ve:Ye,dt):null,fn.values[1]=yt!=null?Vi(L.ori==1?Ve:Ye,yt):null}Do(bu,n,Ve,Ye,F,Ct,I)}if(te){let dt=C&&fn.setSeries,yt=Ot.prox;Ks==null?os<=yt&&zi(Ts,Ur,!0,dt):os>yt?zi(null,Ur,!0,dt):Ts!=Ks&&zi(Ts,Ur,!0,dt)}}pt&&(ft.idx=I,nu()),b!==!1&&En("setCursor")}let As=null;Object.defineProperty(n,"rect",{get(){return As==null&&No(!1),As}});function No(x=!1){x?As=null:(As=g.getBoundingClientRect(),En("syncRect",As))}function qd(x,b,C,I,B,Z,at){ut._lock||ws&&x!=null&&x.movementX==0&&x.movementY==0||(iu(x,b,C,I,B,Z,at,!1,x!=null),x!=null?js(null,!0,!0):js(b,!0,!1))}function iu(x,b,C,I,B,Z,at,dt,yt){if(As==null&&No(!1),Qt(x),x!=null)C=x.clientX-As.left,I=x.clientY-As.top;else{if(C<0||I<0){Ve=-10,Ye=-10;return}let[Nt,Dt]=fn.scales,Ft=b.cursor.sync,[re,Ee]=Ft.values,[Se,xe]=Ft.scales,[Kt,Xt]=fn.match,Ge=b.axes[0].side%2==1,en=L.ori==0?F:Ct,Tn=L.ori==1?F:Ct,Ne=Ge?Z:B,nn=Ge?B:Z,ti=Ge?I:C,Vn=Ge?C:I;if(Se!=null?C=Kt(Nt,Se)?a(re,w[Nt],en,0):-10:C=en*(ti/Ne),xe!=null?I=Xt(Dt,xe)?a(Ee,w[Dt],Tn,0):-10:I=Tn*(Vn/nn),L.ori==1){let pi=C;C=I,I=pi}}yt&&(b==null||b.cursor.event.type==bu)&&((C<=1||C>=F-1)&&(C=ir(C,F)),(I<=1||I>=Ct-1)&&(I=ir(I,Ct))),dt?(zd=C,Vd=I,[Lr,Nr]=ut.move(n,C,I)):(Ve=C,Ye=I)}let su={width:0,height:0,left:0,top:0};function ru(){Oa(su,!1)}let $d,Yd,Zd,Jd;function Kd(x,b,C,I,B,Z,at){ws=!0,Mn=wn=Pn._x=Pn._y=!1,iu(x,b,C,I,B,Z,at,!0,!1),x!=null&&(be(Su,Au,jd,!1),Do(Cp,n,Lr,Nr,F,Ct,null));let{left:dt,top:yt,width:Nt,height:Dt}=He;$d=dt,Yd=yt,Zd=Nt,Jd=Dt}function jd(x,b,C,I,B,Z,at){ws=Pn._x=Pn._y=!1,iu(x,b,C,I,B,Z,at,!1,!0);let{left:dt,top:yt,width:Nt,height:Dt}=He,Ft=Nt>0||Dt>0,re=$d!=dt||Yd!=yt||Zd!=Nt||Jd!=Dt;if(Ft&&re&&Oa(He),Pn.setScale&&Ft&&re){let Ee=dt,Se=Nt,xe=yt,Kt=Dt;if(L.ori==1&&(Ee=yt,Se=Dt,xe=dt,Kt=Nt),Mn&&Es(T,Vi(Ee,T),Vi(Ee+Se,T)),wn)for(let Xt in w){let Ge=w[Xt];Xt!=T&&Ge.from==null&&Ge.min!=Fe&&Es(Xt,Vi(xe+Kt,Xt),Vi(xe,Xt))}ru()}else ut.lock&&(ut._lock=!ut._lock,js(b,!0,x!=null));x!=null&&(gn(Su,Au),Do(Su,n,Ve,Ye,F,Ct,null))}function y_(x,b,C,I,B,Z,at){if(ut._lock)return;Qt(x);let dt=ws;if(ws){let yt=!0,Nt=!0,Dt=10,Ft,re;L.ori==0?(Ft=Mn,re=wn):(Ft=wn,re=Mn),Ft&&re&&(yt=Ve<=Dt||Ve>=F-Dt,Nt=Ye<=Dt||Ye>=Ct-Dt),Ft&&yt&&(Ve=Ve<Lr?0:F),re&&Nt&&(Ye=Ye<Nr?0:Ct),js(null,!0,!0),ws=!1}Ve=-10,Ye=-10,st.fill(null),js(null,!0,!0),dt&&(ws=dt)}function Qd(x,b,C,I,B,Z,at){ut._lock||(Qt(x),Po(),ru(),x!=null&&Do(Lp,n,Ve,Ye,F,Ct,null))}function tp(){A.forEach(jy),U(n.width,n.height,!0)}or(ll,Gr,tp);let Fr={};Fr.mousedown=Kd,Fr.mousemove=qd,Fr.mouseup=jd,Fr.dblclick=Qd,Fr.setSeries=(x,b,C,I)=>{let B=fn.match[2];C=B(n,b,C),C!=-1&&zi(C,I,!0,!1)},mt&&(be(Cp,g,Kd),be(bu,g,qd),be(Pp,g,x=>{Qt(x),No(!1)}),be(Ip,g,y_),be(Lp,g,Qd),Uu.add(n),n.syncRect=No);let Ba=n.hooks=i.hooks||{};function En(x,b,C){zn?Ie.push([x,b,C]):x in Ba&&Ba[x].forEach(I=>{I.call(null,n,b,C)})}(i.plugins||[]).forEach(x=>{for(let b in x.hooks)Ba[b]=(Ba[b]||[]).concat(x.hooks[b])});let ep=(x,b,C)=>C,fn=dn({key:null,setSeries:!1,filters:{pub:Gp,sub:Gp},scales:[T,y[1]?y[1].scale:null],match:[Wp,Wp,ep],values:[null,null]},ut.sync);fn.match.length==2&&fn.match.push(ep),ut.sync=fn;let np=fn.key,ou=zm(np);function Do(x,b,C,I,B,Z,at){fn.filters.pub(x,b,C,I,B,Z,at)&&ou.pub(x,b,C,I,B,Z,at)}ou.sub(n);function b_(x,b,C,I,B,Z,at){fn.filters.sub(x,b,C,I,B,Z,at)&&Fr[x](null,b,C,I,B,Z,at)}n.pub=b_;function S_(){ou.unsub(n),Uu.delete(n),Sn.clear(),Pu(ll,Gr,tp),c.remove(),At?.remove(),En("destroy")}n.destroy=S_;function au(){En("init",i,t),Co(t||i.data,!1),z[T]?Qh(T,z[T]):Po(),it=He.show&&(He.width>0||He.height>0),et=pt=!0,U(i.width,i.height)}return y.forEach(Tr),A.forEach(ns),e?e instanceof HTMLElement?(e.appendChild(c),au()):e(n,au):au(),n}In.assign=dn;In.fmtNum=Hu;In.rangeNum=cl;In.rangeLog=fl;In.rangeAsinh=zu;In.orient=lr;In.pxRatio=Te;In.join=Gv;In.fmtDate=Wu,In.tzDate=ty;In.sync=zm;{In.addGap=Fy,In.clipGaps=ml;let i=In.paths={points:qm};i.linear=Ym,i.stepped=ky,i.bars=zy,i.spline=Hy}var Wo=class{#t=[];#i;#n;#e=0;constructor(t,e){this.#i=Array.from({length:t},()=>[]),this.#n=e}get length(){return this.#t.length-this.#e}get now(){return this.#t.at(-1)}clear(){this.#t=[],this.#i=this.#i.map(()=>[]),this.#e=0}push(t,e){if(Number.isFinite(t)){if(this.length&&t===this.now)return this.#s(e);for(this.length&&(t<this.now||t>this.now+this.#n)&&this.clear(),this.#t.push(t),this.#i.forEach((n,s)=>n.push(jm(e[s])));this.#t[this.#e]<t-this.#n;)this.#e+=1;this.#e>1024&&this.#a()}}gap(){this.length&&this.push(this.now+1e-6,[])}rows(t){let e=this.#e;for(;this.#t[e]<this.now-t;)e+=1;return e>this.#e&&(e-=1),[this.#t,...this.#i].map(n=>n.slice(e))}#s(t){this.#i.forEach((e,n)=>e[e.length-1]=jm(t[n]))}#a(){this.#t.splice(0,this.#e);for(let t of this.#i)t.splice(0,this.#e);this.#e=0}};function jm(i){return Number.isFinite(i)?i:null}function Qm(i,t){let e=i.flatMap((n,s)=>s===0||n-i[s-1]>t?[s]:[]);return e.map((n,s)=>[n,e[s+1]??i.length])}var vl=class{#t;#i;constructor(t,e){this.#t=Array.from({length:t},()=>({track:null,seen:-1/0})),this.#i=e}clear(){for(let t of this.#t)Object.assign(t,{track:null,seen:-1/0})}of(t,e){let n=this.#t.findIndex(s=>s.track===t);return n<0&&(n=this.#n(e)),n>=0&&(this.#t[n]={track:t,seen:e}),n}#n(t){let e=-1;return this.#t.forEach(({track:n,seen:s},r)=>{(n===null||t-s>this.#i||t<s)&&(e<0||s<this.#t[e].seen)&&(e=r)}),e}};var Ds=6,Ku=30,Qy=.3,tg=1,tb=100,eb='11px system-ui, "Segoe UI", Roboto, sans-serif';function nb(i,t){let e=Math.floor(Math.log10(Math.max(i,.001))),n=Math.ceil(Math.log10(Math.max(t,.001))+1e-9);return[10**e,10**Math.max(n,e+1)]}var yl=class{#t;#i;#n=new Wo(2*Ds,Ku);#e=new Wo(4,Ku);#s=new vl(Ds,Qy);#a=10;#r=NaN;#o=0;#h=null;#u=null;#c=null;#f=[];constructor(t,e){let n=Array.from({length:Ds},(s,r)=>r);this.#t=eg(t,{series:[...n.map(s=>({stroke:ju(s),width:1.75,points:Qu(ju(s))})),...n.map(s=>({stroke:ju(s),width:1,dash:[3,4]}))],x:()=>this.#x(this.#n),y:(s,r,o)=>[0,Math.max(1,(o??0)*1.1)],label:s=>s.map((r,o)=>Gt(r,Xa((s[1]??1)-(s[0]??0)))),splits:(s,r)=>Wa(s,r,4),tip:s=>this.#b(s)}),this.#i=eg(e,{series:[{stroke:()=>An("--line"),width:1.5,points:Qu(()=>An("--line"))},{stroke:()=>An("--slot-5"),width:1.25,points:Qu(()=>An("--slot-5"))},{stroke:()=>An("--late"),width:1.25,dash:[6,4]},{stroke:()=>An("--late"),points:{show:!0,size:4,fill:()=>An("--late")},paths:()=>null}],x:()=>this.#x(this.#e),y:(s,r,o)=>nb(r??100,o??1e3),log:!0,label:s=>s.map(r=>Math.log10(r)%1===0?ab(r):""),splits:(s,r)=>ob(s,r),tip:rb})}slotOf(t){return this.#s.of(t,this.#n.now??0)}setWindow(t){this.#a=t,this.draw(!0)}setDeadline(t){this.#r=Number.isFinite(t)?t:NaN}until(t){t===null&&this.#u!==null&&this.#g(),this.#u=t,this.draw(!0)}recolour(){this.#t.redraw(!1,!0),this.#i.redraw(!1,!0)}clear(){this.#f=[],this.#c=this.#u=null,this.#l(),this.draw(!0)}recall(t){this.#f=ib(t),this.#c&&(this.#l(this.#c.time),this.#d(),this.draw(!0))}#l(t=NaN){this.#n.clear(),this.#e.clear(),this.#s.clear();let e=t;for(let[n,s]of this.#f)n>t-Ku&&n<t&&(n-e>tg&&this.#n.gap(),this.#n.push(e=n,this.#p(n,[...s].map(([r,o])=>({contact:{key:r,force:o}})))))}#p(t,e){let n=Array(2*Ds).fill(NaN);for(let{contact:s,truth:r}of e){let o=this.#s.of(s.key,t);o<0||(n[o]=s.force,r&&(n[Ds+o]=r.force))}return n}add(t,e,{ready_us:n,latency_us:s,late:r}){if(!Number.isFinite(t))return;let o=t>=this.#n.now&&t<=this.#n.now+tg;this.#f.length&&!o?this.#l(t):t<this.#n.now?this.#s.clear():o||this.#g();let[a,l]=[s,n].map(c=>c>0?c:NaN);this.#c={time:t,pairs:e,times:[a,l,this.#r,r?l:NaN]},this.#d(),this.draw()}#d(){let{time:t,pairs:e,times:n}=this.#c;this.#n.push(t,this.#p(t,e)),this.#e.push(t,n)}#g(){for(let t of[this.#n,this.#e])t.gap()}draw(t=!1){let e=t?0:this.#o+tb-performance.now();if(e>0){this.#h??=setTimeout(()=>this.draw(!0),e);return}clearTimeout(this.#h),this.#h=null,this.#o=performance.now(),this.#t.setData(this.#n.length?this.#m(this.#n):tf(2*Ds)),this.#i.setData(this.#e.length?this.#m(this.#e):tf(4))}#m(t){return t.rows(this.#a+t.now-(this.#u??t.now))}#x(t){let e=this.#u??t.now??0;return[e-this.#a,e]}#b(t){let e=[];for(let n=0;n<Ds;n+=1){let[s,r]=[t[n],t[Ds+n]];s!=null&&e.push({slot:n,text:`${Gt(s,2)}${r==null?"":`, truth ${Gt(r,2)}`}`})}return e}};function ib(i){let t=new Map;for(let[e,[n,s]]of Object.entries(i))n.forEach((r,o)=>{t.has(r)||t.set(r,new Map),t.get(r).set(e,s[o])});return[...t].sort(([e],[n])=>e-n)}var sb=["whole","answer","deadline"];function rb(i){return sb.flatMap((t,e)=>i[e]==null?[]:[{text:`${t} ${er(i[e])}`}])}function ju(i){return()=>An(`--slot-${i}`)}function Qu(i){return{show:!1,size:3.5,fill:i,filter:({data:e},n)=>{let s=e[n],r=s.flatMap((o,a)=>o!==null&&s[a-1]==null&&s[a+1]==null?[a]:[]);return r.length?r:null}}}function tf(i){return Array.from({length:i+1},()=>[])}function ob(i,t){let e=[];for(let n=i;n<=t*1.001;n*=10)e.push(n,2*n,5*n);return e.filter(n=>n<=t*1.001)}function ab(i){let[t,e]=[[1e6,"M"],[1e3,"k"],[1,""]].find(([n])=>i>=n)??[1,""];return`${Cs(i/t,1)}${e}`}function eg(i,{series:t,x:e,y:n,label:s,splits:r,tip:o,log:a=!1}){let l=()=>({width:Math.max(i.clientWidth,60),height:Math.max(i.clientHeight,60)}),c={stroke:()=>An("--muted"),grid:{stroke:()=>An("--grid"),width:1},ticks:{show:!1},font:eb},h=new In({...l(),padding:[8,10,0,0],legend:{show:!1},cursor:{y:!1,drag:{x:!1,y:!1},points:{size:6}},hooks:{setCursor:[f=>lb(f,o)]},scales:{x:{time:!1,range:e},y:{range:n,...a?{distr:3}:{}}},series:[{},...t.map(f=>({points:{show:!1},spanGaps:!1,...f}))],axes:[{...c,size:24,gap:4,splits:(f,u,d,g)=>hb(d,g),values:(f,u)=>u.map(d=>`${Gt(d-f.scales.x.max,0)}${d===u.at(-1)?" s":""}`)},{...c,size:40,gap:6,splits:(f,u,d,g)=>r(d,g),values:(f,u)=>s(u),...a?{filter:(f,u)=>u}:{}}]},tf(t.length),i);return new ResizeObserver(()=>h.setSize(l())).observe(i),h}function lb(i,t){let{idx:e,left:n}=i.cursor,s=i.root.parentElement;if(s.querySelector(".plot-tip")?.remove(),e==null||!(n>=0))return;let r=t(i.data.slice(1).map(f=>f[e])),o=`${Gt(i.data[0][e]-i.scales.x.max,1)} s`,a=r.map(({slot:f,text:u})=>qt("div",{},cb(f),u)),l=qt("div",{class:"plot-tip num"},qt("div",{text:o}),...a),c=i.bbox.left/devicePixelRatio+n,h=s.clientWidth-c;h<c?l.style.right=`${h+8}px`:l.style.left=`${c+8}px`,s.append(l)}function cb(i){if(i===void 0)return null;let t=qt("i",{class:"swatch"});return t.style.background=`var(--slot-${i})`,t}function hb(i,t){return[0,1,2,3,4,5].map(e=>i+e*(t-i)/5)}function ng(i,t){let e=Number.isFinite(t)?`, deadline ${er(t)}`:"";return`${er(i)}${e}`}var bl=class{#t;#i;#n=new Map;#e=null;#s=0;#a;friction=0;constructor(t,e,n="p"){this.#t=t,this.#i=e,this.#a=n}get ids(){return[...this.#n.keys()]}missing(t){let e=n=>t.some(s=>s===n||String(s).endsWith(`-${n}`));return[...this.#n].filter(([n])=>!e(n)).map(([n,{position:s}])=>({id:n,position:s}))}get newest(){let[t,e]=[...this.#n].at(-1)??[];return t?{id:t,...e}:null}shift(t,e,n){let s=this.#n.get(t);s&&(Object.assign(s,{patch:e,position:n}),this.#t({do:"move",id:t,patch:e,position:n}))}settle(t,e,n){let s=this.#n.get(t);s&&this.#e?.id!==t&&Object.assign(s,{patch:e,position:n})}get holding(){return this.#e!==null}down(t){this.#e&&this.#c(t.time);let e=t.id!=null&&(this.#n.has(t.id)||t.grab===!0),n=e?t.id:this.#o(t);e&&!this.#n.has(n)&&this.#n.set(n,{...this.#u(t),standing:!0}),this.#e={id:n,since:t.time,x:t.x,y:t.y,dragged:!1,grabbed:e,shift:t.shift,push:t.alt,sent:t.time}}move(t){let e=this.#e;if(!e||(Math.hypot(t.x-e.x,t.y-e.y)>6&&(e.dragged=!0),!e.dragged||!t.position))return;let n=this.#n.get(e.id);n&&(e.push?n.shear=this.#r(n,t.position):Object.assign(n,{patch:t.patch,position:t.position}),e.waiting=!0,(t.time-e.sent>=1/40||t.time<e.sent)&&this.#f(t.time))}up(t){this.#e&&this.#c(t.time)}cancel(){let t=this.#e;this.#e=null,t&&!t.grabbed&&this.#l(t.id)}tap(t){this.#n.get(this.#o(t)).standing=!0}setForce(t){let[e,n]=[...this.#n].at(-1)??[];if(!n)return;n.force=t;let{patch:s,position:r}=n;this.#t({do:"move",id:e,patch:s,position:r,force:t})}liftMine(){for(let t of this.ids)this.#l(t);this.#e=null}liftAll(){this.forget(),this.#t({do:"lift",id:null})}forget(){this.#n.clear(),this.#e=null}#r({position:t,force:e},n){let s=n.map((o,a)=>o-t[a]),r=Math.min(1,Math.hypot(...s)/.01)/(Math.hypot(...s)||1);return s.map(o=>o*r*this.friction*(e??this.#i().force))}#o(t){t.shift||this.liftMine(),this.#s+=1;let e=`${this.#a}${this.#s}`,n=this.#u(t);return this.#n.set(e,{...n,standing:!1}),this.#h(e,n),e}async#h(t,e){await this.#t({do:"press",id:t,...e})===!1&&(this.#n.delete(t),this.#e?.id===t&&(this.#e=null))}#u({patch:t,position:e}){let{shape:n,radius:s,force:r}=this.#i();return{patch:t,position:e,force:r,radius:s,shape:n}}#c(t){let e=this.#e;this.#e=null,e.waiting&&this.#f(t,e);let n=t-e.since<.4&&!e.dragged,s=e.grabbed?!(n&&e.shift):n,r=this.#n.get(e.id);s&&r?r.standing=!0:this.#l(e.id)}#f(t,e=this.#e){let{patch:n,position:s,shear:r}=this.#n.get(e.id);this.#t({do:"move",id:e.id,patch:n,position:s,...e.push?{shear:r}:{}}),e.sent=t,e.waiting=!1}#l(t){this.#n.delete(t)&&this.#t({do:"lift",id:t})}};var ub=12,ig=16,ef={ball:"Ball",flat:"Flat end",finger:"Finger",L:"Letter L",T:"Letter T"},sg={finger:"Finger",L:"L",T:"T"},fb=500,db=400,pb=.002,Sl=class{#t;#i;#n;#e=null;#s=null;#a=null;#r="live";#o=null;#h=new Wi(()=>this.#v());#u={};#c={ready:[],preparing:[]};#f=[];#l=-1/0;#p=null;constructor(t,e){this.#t=t,this.#i=e;let n=`${Date.now().toString(36).slice(-5)}${Math.floor(Math.random()*1296).toString(36)}.`;this.#n=new bl(t,()=>this.tool,n),rg("radius",()=>this.#_(),{position:s=>this.#g(s),value:s=>this.#d[s]??X("radius").valueAsNumber}),rg("force",()=>this.#_(!0)),X("shape").addEventListener("change",()=>this.#_()),X("lift").addEventListener("click",()=>this.liftAll()),X("press-middle").addEventListener("click",()=>this.pressMiddle()),X("press-scene").addEventListener("change",({target:s})=>this.#h.wait("scene",this.#t({do:"scene",name:s.value})))}get tool(){return{shape:X("shape").value,radius:X("radius").valueAsNumber/1e3,force:X("force").valueAsNumber}}get#d(){let{shape:t}=this.tool,e=this.#c.ready.filter(o=>o.shape===t).map(({radius:o})=>o),[n,s]=this.#e?.radius??[0,1/0],r=[...this.#u[t]??[],...e].filter(o=>o>=n&&o<=s);return[...new Set(r.map(Us))].sort((o,a)=>o-a)}#g(t){let e=this.#d.map(n=>Math.abs(n-t));return e.indexOf(Math.min(...e))}get able(){return this.#e!==null&&!this.#s}hello({press:t,mode:e}){this.#e=t??null,this.#r=e,this.#s=null,t&&this.#A(t),this.#S()}controls({off:t,scene:e,busy:n,tools:s}){this.#c=s??{ready:[],preparing:[]},this.#s=t?.press??null,this.#a=n??null,this.#o=e,this.#h.settled(),this.#v(),this.#S(),this.#M()}gesture(t,{patch:e,position:n,id:s,event:r}={}){if(!this.able&&t==="begin")return;let o={patch:e,position:n?Array.from(n):null,id:this.#x(s),x:r?.clientX??0,y:r?.clientY??0,shift:!!r?.shiftKey,alt:!!r?.altKey,time:(r?.timeStamp||performance.now())/1e3},l={begin:"down",move:"move",end:t==="end"&&r&&r.type!=="pointerup"?"cancel":"up"};this.#n[l[t]](o)}pressMiddle(){if(!this.able)return;let t=this.#m();t?this.#n.tap({patch:t.patch,position:Array.from(t.position)}):Xi("info","no skin is in the picture: Home shows the whole of it")}shift(t,e){let n=this.#n.newest;if(!n||!this.able)return!1;let s=this.#f.find(({id:u})=>this.#x(u)===n.id)?.normal,{elements:r}=this.#i.view.camera.matrixWorld,o=[0,1,2].map(u=>t*r[u]+e*r[4+u]),a=mb(o,s??[0,0,1],Math.hypot(t,e)),l=n.position.map((u,d)=>u+a[d]),{x:c,y:h}=this.#i.project(l),f=this.#i.pickAtRest(c,h);return f?.position&&Math.hypot(...f.position.map((u,d)=>u-l[d]))<pb&&(this.#l=performance.now(),this.#n.shift(n.id,f.patch,l)),!0}harder(t){if(!this.#n.newest||!this.able)return!1;let e=X("force");return e.value=Number((e.valueAsNumber+t).toFixed(3)),e.dispatchEvent(new Event("change")),!0}#m(){let{clientWidth:t,clientHeight:e}=this.#i.canvas;for(let n=0;n<Math.hypot(t,e)/2;n+=ub)for(let s=0;s<(n?ig:1);s+=1){let r=2*Math.PI*s/ig-Math.PI/2,[o,a]=[t/2+n*Math.cos(r),e/2+n*Math.sin(r)],c=o>=0&&a>=0&&o<t&&a<e?this.#i.pick(o,a):null;if(c?.position)return c}return null}seen(t){if(this.#f=t,performance.now()-this.#l>db)for(let{id:s,patch:r,position:o}of t)this.#n.settle(this.#x(s),r,o);let e=this.#a&&this.#T!==null?`${this.#a}, ${og(this.#T)}`:this.#a,n=e?this.#n.missing(t.map(({id:s})=>s)):[];this.#i.setWaiting(n.map(s=>({...s,why:e})))}forget(){this.#n.forget()}leave(){this.#n.liftMine()}liftAll(){this.able&&this.#n.liftAll()}#x(t){return t==null?null:this.#n.ids.find(e=>t===e||String(t).endsWith(`-${e}`))??null}get#b(){return this.#r==="replay"?"a recording cannot be pressed":this.#e?this.#s:this.#s??"a real skin is pressed by hand"}#S(){let t=this.#b;for(let n of X("tools").querySelectorAll("button"))gi(n,t);for(let n of["shape","press-scene","radius","radius-slider","force","force-slider","lift","press-middle"])gi(X(n),t);let e=this.#e?.scenes??[];t||gi(X("press-scene"),e.length?null:"this skin has no scenes"),document.body.classList.toggle("no-press",!this.#e),X("press-panel").classList.toggle("is-off",!!t),le(X("press-note"),t??(Va()?"tap stays · hold lifts":"click stays · hold lifts · Shift adds"))}#v(){typeof this.#o!="string"||this.#h.has("scene")||X("press-scene").value!==this.#o&&(X("press-scene").value=this.#o)}#A({shapes:t,radius:e,force:n,scenes:s,common:r,friction:o}){this.#n.friction=o??0,this.#u=r??{},this.#P(),Rs(X("shape"),t.map(a=>[a,ef[a]??a])),Rs(X("press-scene"),(s??[]).map(a=>[a,a])),ag("radius",e.map(a=>a*1e3)),ag("force",n),this.#_()}#_(t=!1){let e=this.tool;if(this.#i.setTool(e),this.#M(),t)return this.#n.setForce(e.force);clearTimeout(this.#p),this.#p=setTimeout(()=>this.#R(),fb)}#R(){let{shape:t,radius:e}=this.tool;!this.able||this.#E(this.tool)||!Number.isFinite(e)||this.#t({do:"tool",shape:t,radius:e})}#E(t){return this.#c.ready.some(e=>nf(e,t))}get#T(){return this.#c.preparing.find(t=>nf(t,this.tool))?.share??null}#P(){let e=Object.entries(this.#u).flatMap(([n,s])=>s.map(r=>({shape:n,radius:r}))).map(({shape:n,radius:s})=>{let[r,o]=[ef[n]??n,`${Us(s)} mm`],a=qt("button",{type:"button",class:"tool","data-testid":`tool-${n}-${Us(s)}`,"aria-label":`${r}, radius ${o}`},n in sg?null:qt("i",{class:`tool-shape ${n}`,"aria-hidden":"true"}),qt("span",{text:sg[n]??String(Us(s))}));return Object.assign(a.dataset,{shape:n,radius:s}),a.addEventListener("click",()=>this.#y(n,s)),a});X("tools").replaceChildren(...e)}#y(t,e){X("shape").value=t,X("radius").value=Us(e),this.#_()}#M(){let t=this.tool;for(let s of X("tools").querySelectorAll("button")){let r={shape:s.dataset.shape,radius:Number(s.dataset.radius)},o=this.#E(r);s.setAttribute("aria-pressed",String(nf(r,t))),s.classList.toggle("is-waiting",!o),s.disabled||(s.title=`${s.getAttribute("aria-label")}${o?"":": is being prepared"}`)}let[e,n]=[X("radius-slider"),this.#d];Object.assign(e,{min:0,max:Math.max(n.length-1,0),step:1}),e.value=this.#g(X("radius").valueAsNumber),e.setAttribute("aria-valuetext",`${n[e.value]??"–"} mm`),this.#C(this.#e&&!this.#E(t)?this.#T:null)}#C(t){if(X("tool-progress").hidden=t===null,t===null)return;let{shape:e,radius:n}=this.tool;X("tool-share").value=t,le(X("tool-words"),`${ef[e]??e} of ${Us(n)} mm: being prepared, ${og(t)}`)}};function rg(i,t,{position:e=s=>s,value:n=s=>s}={}){let[s,r]=[X(i),X(`${i}-slider`)];r.addEventListener("input",()=>{s.value=n(r.valueAsNumber),t()}),s.addEventListener("input",()=>{!s.validity.valid||s.value===""||(r.value=e(s.valueAsNumber),t())}),s.addEventListener("change",()=>{let o=Number.isFinite(s.valueAsNumber)?s.valueAsNumber:n(r.valueAsNumber);s.value=Uo(o,Number(s.min),Number(s.max)),r.value=e(s.valueAsNumber),t()})}function nf(i,t){return i.shape===t.shape&&Us(i.radius)===Us(t.radius)}function Us(i){return Math.round(i*1e4)/10}function og(i){return`${Math.round(100*i)} %`}function mb(i,t,e){let n=i.reduce((o,a,l)=>o+a*t[l],0),s=i.map((o,a)=>o-n*t[a]),r=Math.hypot(...s);return r>1e-9?s.map(o=>o*e/r):[0,0,0]}function ag(i,[t,e,n]){let s=X(i),r=X(`${i}-slider`),o=s.value===""?n:Uo(s.valueAsNumber,t,e);for(let a of i==="radius"?[s]:[s,r])a.min=Number(t.toPrecision(6)),a.max=Number(e.toPrecision(6));s.step="any",r.step=Number(((e-t)/200).toPrecision(2)),s.value=Number(o.toPrecision(6)),r.value=s.value}var lg=8,gb=.5,cg=4,xb=1,Ml=class{#t;#i=null;constructor(t){this.#t=t,new ResizeObserver(()=>this.draw()).observe(t)}show(t){this.#i=t,this.draw()}draw(){let{clientWidth:t,clientHeight:e}=this.#t,n=window.devicePixelRatio||1;Object.assign(this.#t,{width:Math.round(t*n),height:Math.round(e*n)});let s=this.#t.getContext("2d");if(s.scale(n,n),!this.#i||!(this.#i.end>this.#i.start))return;let{start:r,end:o,times:a,force:l,touches:c,unit:h}=this.#i,f=y=>lg+(y-r)/(o-r)*(t-2*lg),u=l.reduce((y,A)=>Math.max(y,A||0),gb),d=e-cg-1,g=y=>d-(d-2)*y/u;for(let[y,A]of Qm(a,Math.max(xb,(o-r)/300)))this.#n(s,a.slice(y,A).map(f),l.slice(y,A).map(g),d);this.#e(s,c,f,[r,o],d);let M=`${Gt(u,u<10?1:0)} ${h??"N"}`,m=`${c.length} touch${c.length===1?"":"es"}`,p=`Total force over time, up to ${M}; ${m}, marked where they begin and end`;this.#t.title!==p&&this.#t.setAttribute("aria-label",this.#t.title=p)}#n(t,e,n,s){t.beginPath(),e.forEach((r,o)=>t.lineTo(r,Number.isFinite(n[o])?n[o]:s)),t.strokeStyle=An("--accent"),t.lineWidth=1.25,t.stroke(),t.lineTo(e.at(-1),s),t.lineTo(e[0],s),t.globalAlpha=.22,t.fillStyle=An("--accent"),t.fill(),t.globalAlpha=1}#e(t,e,n,[s,r],o){t.strokeStyle=t.fillStyle=An("--waiting");for(let[a,l]of e){if(l<s||a>r)continue;let[c,h]=[n(Math.max(a,s)),n(Math.min(l,r))];t.fillRect(c,o+2,Math.max(h-c,1),1.5);for(let f of[a,l])f>s&&f<r&&t.fillRect(n(f)-.75,o-1,1.5,cg+2)}}};var _b=100,vb=600,yb=250,bb={ArrowLeft:-1,ArrowDown:-1,ArrowRight:1,ArrowUp:1},hg=50,wl=class{#t;#i;#n;#e=null;#s="";#a="";#r=!0;#o=!1;#h=1;#u=new Wi(()=>this.#C());#c=X("time-bar");#f=new Ml(X("time-strip"));#l=new nl;#p=0;#d=null;#g=-1/0;#m=!1;#x=-1/0;#b=!1;constructor(t,e,n){this.#t=t,this.#i=e,this.#n=n;let s=sp(o=>this.#y("seek",o),_b);this.#c.addEventListener("input",()=>{let o=this.#c.valueAsNumber;if(!this.#e)return this.#R(this.#l.end+o);this.#x=performance.now(),this.#M(o),s(o)}),this.#c.addEventListener("keydown",o=>{let a=bb[o.key];a&&(o.preventDefault(),this.step(a))}),this.#c.addEventListener("pointerdown",()=>this.#m=!0);for(let o of["pointerup","pointercancel"])addEventListener(o,()=>this.#m=!1);let r={play:()=>this.toggle(),"step-back":()=>this.step(-1),"step-on":()=>this.step(1),loop:()=>this.loop(),"export-csv":()=>this.saveContacts(),"replay-close":()=>this.#e?this.#y("close"):this.live()};for(let[o,a]of Object.entries(r))X(o).addEventListener("click",a);X("speed").addEventListener("change",({target:o})=>{this.#e?this.#u.wait("speed",this.#y("speed",Number(o.value))):this.#h=Number(o.value)}),X("replay-events").addEventListener("change",o=>this.#U(o.target)),X("recordings").addEventListener("change",o=>this.#D(o.target))}get lookingBack(){return this.#l.held}async toggle(){if(!this.#e)return this.#v();this.#w(!this.#r),await this.#y(this.#r?"play":"pause")||this.#w(!this.#r)}step(t){if(this.#e)return this.#y("step",t);if(!this.#S())return;this.#_();let e=this.#l.placeAt(this.#p)+t;return this.#E(Math.min(Math.max(e,0),this.#l.length-1))}async loop(){this.#I(!this.#o),this.#e&&!await this.#y("loop",this.#o)&&this.#I(!this.#o)}live(){this.lookingBack&&(this.#_(),this.#l.release(),this.#T(),this.#n(this.#l.moment(this.#l.length-1),!0),this.#P(!0))}hello({replay:t,recordings:e,columns:n,name:s}){if(this.#e=t??null,this.#s=n??"",this.#a=s||"skin",this.#_(),this.#l.clear(),this.#f.show(null),document.body.classList.toggle("is-replay",!!t),document.body.classList.toggle("no-recordings",!e?.length),X("replay-close").hidden=!t||!e?.length,this.#N(e??[]),this.#h=1,this.#C(),this.#I(!1),this.#w(!0),!t)return this.#T();let{start_s:r,end_s:o,events:a}=t;Object.assign(this.#c,{min:r,max:o,value:r}),this.#c.setAttribute("aria-label","Time of the recording, s"),this.#M(r),le(X("replay-end"),Ps(o)),this.#L(r,o,a??[])}controls({replay:t}){t&&(this.#w(t.playing!==!1),this.#I(!!t.loop),this.#h=t.speed,this.#u.settled(),this.#C())}timeline({times:t,force:e,touches:n}){if(!this.#e)return;let{start_s:s,end_s:r,events:o}=this.#e;this.#f.show({start:s,end:r,times:t,force:e,touches:n});let a=n.map(([l],c)=>[l,`touch ${c+1} begins`]);this.#L(s,r,[...o??[],...a].sort(([l],[c])=>l-c))}at(t){!this.#e||!Number.isFinite(t)||this.#m||performance.now()-this.#x<vb||(this.#c.value=t,this.#M(t))}keep(t,e,n,s){this.#e||(this.#b=!!e.relative,this.#l.add(t,e,n,s),this.lookingBack||this.#P())}recolour(){this.#f.draw()}async saveContacts(){let t=this.#e?await this.#i({do:"replay",what:"contacts"}):null,e=t?.csv??[this.#s,...this.#l.rows(),""].join(`
`);(!this.#e||t)&&yp(`${this.#a}-contacts.csv`,e)}#S(){return this.lookingBack?!0:this.#l.hold()?(this.#p=this.#l.end,X("replay-close").hidden=!1,document.body.classList.add("looking-back"),this.#w(!1),this.#M(0),!0):!1}#v(){if(!this.lookingBack)return void(this.#S()&&this.#E(this.#l.length-1));if(this.#d)return this.#_();this.#w(!0),this.#d=setInterval(()=>this.#A(),hg)}#A(){return this.#p+=this.#h*hg/1e3,this.#p<=this.#l.end?this.#R(this.#p,!0):this.#o?this.#R(this.#l.start,!0):this.live()}#_(){clearInterval(this.#d),this.#d=null,this.lookingBack&&this.#w(!1)}#R(t,e=!1){this.#S()&&(e||this.#_(),this.#E(this.#l.placeAt(t),t))}#E(t,e){let n=this.#l.moment(t);this.#p=e??n.time,this.#c.value=this.#p-this.#l.end,this.#M(this.#p-this.#l.end),this.#n(n)}#T(){document.body.classList.remove("looking-back"),X("replay-marks").replaceChildren(),Object.assign(this.#c,{min:-this.#l.seconds,max:0,value:0}),this.#c.setAttribute("aria-label","Time before now, s"),X("replay-close").hidden=!0,this.#w(!0),le(X("replay-end"),"now"),le(X("replay-now"),`−${this.#l.seconds} s`),this.#c.setAttribute("aria-valuetext","now")}#P(t=!1){if(!t&&performance.now()-this.#g<yb)return;this.#g=performance.now();let e=this.#l.end;this.#f.show({start:e-this.#l.seconds,end:e,unit:this.#b?"rel.":"N",...this.#l.outline()})}#y(t,e){return this.#t({do:"replay",what:t,...e===void 0?{}:{value:e}})}#M(t){let e=this.#e?Ps(t):`${Gt(t,1)} s`;le(X("replay-now"),e),this.#c.setAttribute("aria-valuetext",this.#e?`${e} of ${Ps(this.#e.end_s)}`:e)}#C(){if(this.#u.has("speed"))return;let e=[...X("speed").options].find(({value:n})=>Math.abs(Number(n)-this.#h)<1e-6);e&&X("speed").value!==e.value&&(X("speed").value=e.value)}#w(t){this.#r=t,X("play").classList.toggle("playing",t);let e=t?"Pause":"Play";X("play").setAttribute("aria-label",this.#e||!t?e:"Pause and look back")}#I(t){this.#o=t,X("loop").setAttribute("aria-pressed",String(t))}#N(t){let e=X("recordings"),n=t.length?"Open a recording …":"No recording yet";Rs(e,[["",n],...t.map(s=>[s,s])]),e.value="",e.disabled=t.length===0,e.title=t.length?"Shown in this browser alone":"Record something first"}async#D(t){let e=t.value;t.value="",e&&(t.setAttribute("aria-busy","true"),await this.#y("open",e),t.removeAttribute("aria-busy"))}#L(t,e,n){let r=(this.#e.events??[]).map(([a,l])=>{let c=qt("i",{title:`${Ps(a)} ${l}`});return c.style.left=`${100*(a-t)/Math.max(e-t,1e-9)}%`,c});X("replay-marks").replaceChildren(...r);let o=n.map(([a,l])=>[a,`${Ps(a)}  ${l}`]);Rs(X("replay-events"),[["","Events"],...o]),X("replay-events").value="",X("replay-events").disabled=n.length===0}#U(t){t.value!==""&&this.#y("seek",Number(t.value)),this.#x=-1/0,t.value=""}};function El(i){let t=10**Math.floor(Math.log10(i)),e=[1,2,5,10].map(s=>s*t),n=s=>Math.abs(Math.log(s/i));return e.reduce((s,r)=>n(r)<n(s)?r:s)}function ug(i){let t=10**Math.floor(Math.log10(i));return[5,2,1].map(e=>e*t).find(e=>e<=i*(1+1e-9))??t}function Xo(i){return i>=.9999?`${Number(i.toPrecision(3))} m`:i>=.0999?`${Number((100*i).toPrecision(3))} cm`:`${Number((1e3*i).toPrecision(3))} mm`}var Sb=.75,Mb=.2;function fg(i){let t=Math.sqrt(Math.max(0,1-i*i));return t>1e-6?Math.max(Mb,Sb*i/t):1/0}var wb=3,Eb=18,dg=1.8,Tl=class{#t;#i=X("show-shapes");#n=X("shape-canvas");#e=Is.dark;#s=null;constructor(t){this.#t=t,this.#i.addEventListener("change",()=>this.#a())}hello({mode:t}){gi(this.#i,t==="replay"?"a recording has no images of contacts: they are made of a live skin":null),this.show({}),t!=="replay"&&this.#i.checked&&this.#t({do:"shapes",on:!0})}async#a(){let t=this.#i.checked;this.show({}),await this.#t({do:"shapes",on:t})||(this.#i.checked=!1),this.show({})}recolour(t){this.#e=Is[t],this.#r()}show({shapes:t}){this.#s=t??null,X("shape-inset").hidden=!this.#i.checked||this.#i.disabled,this.#r()}#r(){if(X("shape-inset").hidden)return;let t=(this.#s?.images??[]).slice(0,wb);if(this.#n.hidden=t.length===0,le(X("shape-text"),t.length?t.map(pg).join("; "):this.#o()),!t.length)return;let{clientWidth:e,clientHeight:n}=this.#n,s=window.devicePixelRatio||1;Object.assign(this.#n,{width:Math.round(e*s),height:Math.round(n*s)});let r=this.#n.getContext("2d");r.scale(s,s);let o=e/t.length;t.forEach((a,l)=>Ab(r,a,{left:l*o,width:o-4,height:n},this.#e)),this.#n.setAttribute("aria-label",`Pressure of what touches: ${t.map(pg).join("; ")}`)}#o(){let t=this.#s?.why;return t?`Shapes: ${t}`:"Press, and drag: shapes sharpen as what touches moves by a few millimetres"}};function pg({area:i,force:t,convexity:e,readings:n,peak:s}){let r=Number.isFinite(e)?`convexity ${Gt(e,2)}, `:"";return`${Gt(1e6*i,0)} mm², ${Gt(t,2)} N, up to ${ap(s,"Pa")}, ${r}of ${n} reading${n===1?"":"s"}`}function Tb({rows:i,columns:t,cell:e,low:n},{left:s,width:r,height:o}){let a=Math.min(r/(t*e),(o-Eb)/(i*e)),l=s+(r-a*t*e)/2;return{scale:a,x:c=>l+a*(c-n[0]+e/2),y:c=>a*(i*e-(c-n[1]+e/2))}}function Ab(i,t,e,n){let{rows:s,columns:r,cell:o,low:a,bytes:l,outline:c}=t,{scale:h,x:f,y:u}=Tb(t,e),d=Br("viridis",n),g=new OffscreenCanvas(r,s),M=new ImageData(r,s);for(let y=0;y<s;y+=1)for(let A=0;A<r;A+=1){let w=4*l[y*r+A];M.data.set(d.subarray(w,w+4),4*((s-1-y)*r+A))}g.getContext("2d").putImageData(M,0,0),i.imageSmoothingEnabled=!0;let[m,p]=[f(a[0]-o/2),u(a[1]+(s-.5)*o)];i.drawImage(g,m,p,h*r*o,h*s*o);for(let[y,A]of[[dg+2,n.casing],[dg,n.onSkin.contact]]){i.lineWidth=y,i.strokeStyle=A,i.lineJoin="round";for(let w of c){i.beginPath();for(let[P,T]of w)i.lineTo(f(P),u(T));i.closePath(),i.stroke()}}Rb(i,m,p+h*s*o,h,r*o,n)}function Rb(i,t,e,n,s,r){let o=El(s/3);i.fillStyle=r.muted,i.fillRect(t,e+5,n*o,2);for(let a of[0,o])i.fillRect(t+n*a-.75,e+3,1.5,6);i.font="11px system-ui, sans-serif",i.textBaseline="middle",i.fillText(Xo(o),t+n*o+6,e+7)}var zg=0,Lf=1,Vg=2;var xa=1,Hg=2,vo=3,$s=0,Kn=1,On=2,vr=0,yo=1,Nf=2,Df=3,Uf=4,Pc=5;var yr=100,Gg=101,Wg=102,Xg=103,qg=104,$g=200,Ic=201,Yg=202,Zg=203,Ff=204,_a=205,Jg=206,Kg=207,jg=208,Qg=209,t0=210,e0=211,n0=212,i0=213,s0=214,Kl=0,jl=1,Ql=2,uo=3,tc=4,ec=5,nc=6,ic=7,Of=0,r0=1,o0=2,ji=0,Bf=1,kf=2,zf=3,Vf=4,Hf=5,Gf=6,Wf=7;var Xf=300,br=301,bo=302,Lc=303,Nc=304,sc=1e3,Yi=1001,rc=1002,on=1003,a0=1004;var va=1005;var Zn=1006,Dc=1007;var xs=1008;var fi=1009,qf=1010,$f=1011,So=1012,Uc=1013,Li=1014,Ni=1015,Di=1016,Fc=1017,Oc=1018,Sr=1020,Yf=35902,Zf=35899,Jf=1021,Kf=1022,Ui=1023,ms=1026,_s=1027,jf=1028,Bc=1029,Ys=1030,kc=1031;var zc=1033,ya=33776,ba=33777,Sa=33778,Ma=33779,Vc=35840,Hc=35841,Gc=35842,Wc=35843,Xc=36196,qc=37492,$c=37496,Yc=37488,Zc=37489,wa=37490,Jc=37491,Kc=37808,jc=37809,Qc=37810,th=37811,eh=37812,nh=37813,ih=37814,sh=37815,rh=37816,oh=37817,ah=37818,lh=37819,ch=37820,hh=37821,uh=36492,fh=36494,dh=36495,ph=36283,mh=36284,Ea=36285,gh=36286;var Ko=2300,oc=2301,Zl=2302,Ef=2303,Tf=2400,Af=2401,Rf=2402;var l0=3200;var Qf=0,c0=1,vs="",li="srgb",dr="srgb-linear",jo="linear",Re="srgb";var Jl=7680;var h0=519,u0=512,f0=513,d0=514,td=515,p0=516,m0=517,ed=518,nd=519,id=35044,ys=35048;var sd="300 es",yi=2e3,Qo=2001;function Cb(i){for(let t=i.length-1;t>=0;--t)if(i[t]>=65535)return!0;return!1}function Pb(i){return ArrayBuffer.isView(i)&&!(i instanceof DataView)}function ta(i){return document.createElementNS("http://www.w3.org/1999/xhtml",i)}function g0(){let i=ta("canvas");return i.style.display="block",i}var mg={},fo=null;function ea(...i){let t="THREE."+i.shift();fo?fo("log",t,...i):console.log(t,...i)}function x0(i){let t=i[0];if(typeof t=="string"&&t.startsWith("TSL:")){let e=i[1];e&&e.isStackTrace?i[0]+=" "+e.getLocation():i[1]='Stack trace not available. Enable "THREE.Node.captureStackTrace" to capture stack traces.'}return i}function jt(...i){i=x0(i);let t="THREE."+i.shift();if(fo)fo("warn",t,...i);else{let e=i[0];e&&e.isStackTrace?console.warn(e.getError(t)):console.warn(t,...i)}}function ne(...i){i=x0(i);let t="THREE."+i.shift();if(fo)fo("error",t,...i);else{let e=i[0];e&&e.isStackTrace?console.error(e.getError(t)):console.error(t,...i)}}function Jo(...i){let t=i.join(" ");t in mg||(mg[t]=!0,jt(...i))}function _0(i,t,e){return new Promise(function(n,s){function r(){switch(i.clientWaitSync(t,i.SYNC_FLUSH_COMMANDS_BIT,0)){case i.WAIT_FAILED:s();break;case i.TIMEOUT_EXPIRED:setTimeout(r,e);break;default:n()}}setTimeout(r,e)})}var v0={[Kl]:Kl,[Ql]:nc,[tc]:tc,[uo]:ec,[jl]:jl,[nc]:Ql,[ic]:ic,[ec]:uo},Zi=class{addEventListener(t,e){this._listeners===void 0&&(this._listeners={});let n=this._listeners;n[t]===void 0&&(n[t]=[]),n[t].indexOf(e)===-1&&n[t].push(e)}hasEventListener(t,e){let n=this._listeners;return n===void 0?!1:n[t]!==void 0&&n[t].indexOf(e)!==-1}removeEventListener(t,e){let n=this._listeners;if(n===void 0)return;let s=n[t];if(s!==void 0){let r=s.indexOf(e);r!==-1&&s.splice(r,1)}}dispatchEvent(t){let e=this._listeners;if(e===void 0)return;let n=e[t.type];if(n!==void 0){t.target=this;let s=n.slice(0);for(let r=0,o=s.length;r<o;r++)s[r].call(this,t);t.target=null}}},Dn=["00","01","02","03","04","05","06","07","08","09","0a","0b","0c","0d","0e","0f","10","11","12","13","14","15","16","17","18","19","1a","1b","1c","1d","1e","1f","20","21","22","23","24","25","26","27","28","29","2a","2b","2c","2d","2e","2f","30","31","32","33","34","35","36","37","38","39","3a","3b","3c","3d","3e","3f","40","41","42","43","44","45","46","47","48","49","4a","4b","4c","4d","4e","4f","50","51","52","53","54","55","56","57","58","59","5a","5b","5c","5d","5e","5f","60","61","62","63","64","65","66","67","68","69","6a","6b","6c","6d","6e","6f","70","71","72","73","74","75","76","77","78","79","7a","7b","7c","7d","7e","7f","80","81","82","83","84","85","86","87","88","89","8a","8b","8c","8d","8e","8f","90","91","92","93","94","95","96","97","98","99","9a","9b","9c","9d","9e","9f","a0","a1","a2","a3","a4","a5","a6","a7","a8","a9","aa","ab","ac","ad","ae","af","b0","b1","b2","b3","b4","b5","b6","b7","b8","b9","ba","bb","bc","bd","be","bf","c0","c1","c2","c3","c4","c5","c6","c7","c8","c9","ca","cb","cc","cd","ce","cf","d0","d1","d2","d3","d4","d5","d6","d7","d8","d9","da","db","dc","dd","de","df","e0","e1","e2","e3","e4","e5","e6","e7","e8","e9","ea","eb","ec","ed","ee","ef","f0","f1","f2","f3","f4","f5","f6","f7","f8","f9","fa","fb","fc","fd","fe","ff"];var sf=Math.PI/180,ac=180/Math.PI;function Mr(){let i=Math.random()*4294967295|0,t=Math.random()*4294967295|0,e=Math.random()*4294967295|0,n=Math.random()*4294967295|0;return(Dn[i&255]+Dn[i>>8&255]+Dn[i>>16&255]+Dn[i>>24&255]+"-"+Dn[t&255]+Dn[t>>8&255]+"-"+Dn[t>>16&15|64]+Dn[t>>24&255]+"-"+Dn[e&63|128]+Dn[e>>8&255]+"-"+Dn[e>>16&255]+Dn[e>>24&255]+Dn[n&255]+Dn[n>>8&255]+Dn[n>>16&255]+Dn[n>>24&255]).toLowerCase()}function ye(i,t,e){return Math.max(t,Math.min(e,i))}function Ib(i,t){return(i%t+t)%t}function rf(i,t,e){return(1-e)*i+e*t}function y0(i){return Math.pow(2,Math.floor(Math.log(i)/Math.LN2))}function xh(i){switch(i.constructor){case Uint32Array:return 4294967295;case Uint16Array:return 65535;case Uint8Array:case Uint8ClampedArray:return 255;case Int32Array:return 2147483647;case Int16Array:return 32767;case Int8Array:return 127;default:return}}function b0(i,t){if(t.constructor===Float32Array)return i;let e=xh(t);if(e===void 0)throw new Error("THREE.MathUtils: Invalid component type.");return Math.max(i/e,-1)}function S0(i,t){if(t.constructor===Float32Array)return i;let e=xh(t);if(e===void 0)throw new Error("THREE.MathUtils: Invalid component type.");return Math.round(i*e)}var Jt=class{static{this.prototype.isVector2=!0}constructor(t=0,e=0){this.x=t,this.y=e}get width(){return this.x}set width(t){this.x=t}get height(){return this.y}set height(t){this.y=t}set(t,e){return this.x=t,this.y=e,this}setScalar(t){return this.x=t,this.y=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;default:throw new Error("THREE.Vector2: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;default:throw new Error("THREE.Vector2: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y)}copy(t){return this.x=t.x,this.y=t.y,this}add(t){return this.x+=t.x,this.y+=t.y,this}addScalar(t){return this.x+=t,this.y+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this}subScalar(t){return this.x-=t,this.y-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this}multiply(t){return this.x*=t.x,this.y*=t.y,this}multiplyScalar(t){return this.x*=t,this.y*=t,this}divide(t){return this.x/=t.x,this.y/=t.y,this}divideScalar(t){return this.multiplyScalar(1/t)}applyMatrix3(t){let e=this.x,n=this.y,s=t.elements;return this.x=s[0]*e+s[3]*n+s[6],this.y=s[1]*e+s[4]*n+s[7],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this}clamp(t,e){return this.x=ye(this.x,t.x,e.x),this.y=ye(this.y,t.y,e.y),this}clampScalar(t,e){return this.x=ye(this.x,t,e),this.y=ye(this.y,t,e),this}clampLength(t,e){let n=this.length();return this.divideScalar(n||1).multiplyScalar(ye(n,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this}negate(){return this.x=-this.x,this.y=-this.y,this}dot(t){return this.x*t.x+this.y*t.y}cross(t){return this.x*t.y-this.y*t.x}lengthSq(){return this.x*this.x+this.y*this.y}length(){return Math.sqrt(this.x*this.x+this.y*this.y)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)}normalize(){return this.divideScalar(this.length()||1)}angle(){return Math.atan2(-this.y,-this.x)+Math.PI}angleTo(t){let e=Math.sqrt(this.lengthSq()*t.lengthSq());if(e===0)return Math.PI/2;let n=this.dot(t)/e;return Math.acos(ye(n,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let e=this.x-t.x,n=this.y-t.y;return e*e+n*n}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this}lerpVectors(t,e,n){return this.x=t.x+(e.x-t.x)*n,this.y=t.y+(e.y-t.y)*n,this}equals(t){return t.x===this.x&&t.y===this.y}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this}rotateAround(t,e){let n=Math.cos(e),s=Math.sin(e),r=this.x-t.x,o=this.y-t.y;return this.x=r*n-o*s+t.x,this.y=r*s+o*n+t.y,this}random(){return this.x=Math.random(),this.y=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y}},Ji=class{constructor(t=0,e=0,n=0,s=1){this.isQuaternion=!0,this._x=t,this._y=e,this._z=n,this._w=s}static slerpFlat(t,e,n,s,r,o,a){let l=n[s+0],c=n[s+1],h=n[s+2],f=n[s+3],u=r[o+0],d=r[o+1],g=r[o+2],M=r[o+3];if(f!==M||l!==u||c!==d||h!==g){let m=l*u+c*d+h*g+f*M;m<0&&(u=-u,d=-d,g=-g,M=-M,m=-m);let p=1-a;if(m<.9995){let y=Math.acos(m),A=Math.sin(y);p=Math.sin(p*y)/A,a=Math.sin(a*y)/A,l=l*p+u*a,c=c*p+d*a,h=h*p+g*a,f=f*p+M*a}else{l=l*p+u*a,c=c*p+d*a,h=h*p+g*a,f=f*p+M*a;let y=1/Math.sqrt(l*l+c*c+h*h+f*f);l*=y,c*=y,h*=y,f*=y}}t[e]=l,t[e+1]=c,t[e+2]=h,t[e+3]=f}static multiplyQuaternionsFlat(t,e,n,s,r,o){let a=n[s],l=n[s+1],c=n[s+2],h=n[s+3],f=r[o],u=r[o+1],d=r[o+2],g=r[o+3];return t[e]=a*g+h*f+l*d-c*u,t[e+1]=l*g+h*u+c*f-a*d,t[e+2]=c*g+h*d+a*u-l*f,t[e+3]=h*g-a*f-l*u-c*d,t}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get w(){return this._w}set w(t){this._w=t,this._onChangeCallback()}set(t,e,n,s){return this._x=t,this._y=e,this._z=n,this._w=s,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._w)}copy(t){return this._x=t.x,this._y=t.y,this._z=t.z,this._w=t.w,this._onChangeCallback(),this}setFromEuler(t,e=!0){let n=t._x,s=t._y,r=t._z,o=t._order,a=Math.cos,l=Math.sin,c=a(n/2),h=a(s/2),f=a(r/2),u=l(n/2),d=l(s/2),g=l(r/2);switch(o){case"XYZ":this._x=u*h*f+c*d*g,this._y=c*d*f-u*h*g,this._z=c*h*g+u*d*f,this._w=c*h*f-u*d*g;break;case"YXZ":this._x=u*h*f+c*d*g,this._y=c*d*f-u*h*g,this._z=c*h*g-u*d*f,this._w=c*h*f+u*d*g;break;case"ZXY":this._x=u*h*f-c*d*g,this._y=c*d*f+u*h*g,this._z=c*h*g+u*d*f,this._w=c*h*f-u*d*g;break;case"ZYX":this._x=u*h*f-c*d*g,this._y=c*d*f+u*h*g,this._z=c*h*g-u*d*f,this._w=c*h*f+u*d*g;break;case"YZX":this._x=u*h*f+c*d*g,this._y=c*d*f+u*h*g,this._z=c*h*g-u*d*f,this._w=c*h*f-u*d*g;break;case"XZY":this._x=u*h*f-c*d*g,this._y=c*d*f-u*h*g,this._z=c*h*g+u*d*f,this._w=c*h*f+u*d*g;break;default:jt("Quaternion: .setFromEuler() encountered an unknown order: "+o)}return e===!0&&this._onChangeCallback(),this}setFromAxisAngle(t,e){let n=e/2,s=Math.sin(n);return this._x=t.x*s,this._y=t.y*s,this._z=t.z*s,this._w=Math.cos(n),this._onChangeCallback(),this}setFromRotationMatrix(t){let e=t.elements,n=e[0],s=e[4],r=e[8],o=e[1],a=e[5],l=e[9],c=e[2],h=e[6],f=e[10],u=n+a+f;if(u>0){let d=.5/Math.sqrt(u+1);this._w=.25/d,this._x=(h-l)*d,this._y=(r-c)*d,this._z=(o-s)*d}else if(n>a&&n>f){let d=2*Math.sqrt(1+n-a-f);this._w=(h-l)/d,this._x=.25*d,this._y=(s+o)/d,this._z=(r+c)/d}else if(a>f){let d=2*Math.sqrt(1+a-n-f);this._w=(r-c)/d,this._x=(s+o)/d,this._y=.25*d,this._z=(l+h)/d}else{let d=2*Math.sqrt(1+f-n-a);this._w=(o-s)/d,this._x=(r+c)/d,this._y=(l+h)/d,this._z=.25*d}return this._onChangeCallback(),this}setFromUnitVectors(t,e){let n=t.dot(e)+1;return n<1e-8?(n=0,Math.abs(t.x)>Math.abs(t.z)?(this._x=-t.y,this._y=t.x,this._z=0,this._w=n):(this._x=0,this._y=-t.z,this._z=t.y,this._w=n)):(this._x=t.y*e.z-t.z*e.y,this._y=t.z*e.x-t.x*e.z,this._z=t.x*e.y-t.y*e.x,this._w=n),this.normalize()}angleTo(t){return 2*Math.acos(Math.abs(ye(this.dot(t),-1,1)))}rotateTowards(t,e){let n=this.angleTo(t);if(n===0)return this;let s=Math.min(1,e/n);return this.slerp(t,s),this}identity(){return this.set(0,0,0,1)}invert(){return this.conjugate()}conjugate(){return this._x*=-1,this._y*=-1,this._z*=-1,this._onChangeCallback(),this}dot(t){return this._x*t._x+this._y*t._y+this._z*t._z+this._w*t._w}lengthSq(){return this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w}length(){return Math.sqrt(this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w)}normalize(){let t=this.length();return t===0?(this._x=0,this._y=0,this._z=0,this._w=1):(t=1/t,this._x=this._x*t,this._y=this._y*t,this._z=this._z*t,this._w=this._w*t),this._onChangeCallback(),this}multiply(t){return this.multiplyQuaternions(this,t)}premultiply(t){return this.multiplyQuaternions(t,this)}multiplyQuaternions(t,e){let n=t._x,s=t._y,r=t._z,o=t._w,a=e._x,l=e._y,c=e._z,h=e._w;return this._x=n*h+o*a+s*c-r*l,this._y=s*h+o*l+r*a-n*c,this._z=r*h+o*c+n*l-s*a,this._w=o*h-n*a-s*l-r*c,this._onChangeCallback(),this}slerp(t,e){let n=t._x,s=t._y,r=t._z,o=t._w,a=this.dot(t);a<0&&(n=-n,s=-s,r=-r,o=-o,a=-a);let l=1-e;if(a<.9995){let c=Math.acos(a),h=Math.sin(c);l=Math.sin(l*c)/h,e=Math.sin(e*c)/h,this._x=this._x*l+n*e,this._y=this._y*l+s*e,this._z=this._z*l+r*e,this._w=this._w*l+o*e,this._onChangeCallback()}else this._x=this._x*l+n*e,this._y=this._y*l+s*e,this._z=this._z*l+r*e,this._w=this._w*l+o*e,this.normalize();return this}slerpQuaternions(t,e,n){return this.copy(t).slerp(e,n)}random(){let t=2*Math.PI*Math.random(),e=2*Math.PI*Math.random(),n=Math.random(),s=Math.sqrt(1-n),r=Math.sqrt(n);return this.set(s*Math.sin(t),s*Math.cos(t),r*Math.sin(e),r*Math.cos(e))}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._w===this._w}fromArray(t,e=0){return this._x=t[e],this._y=t[e+1],this._z=t[e+2],this._w=t[e+3],this._onChangeCallback(),this}toArray(t=[],e=0){return t[e]=this._x,t[e+1]=this._y,t[e+2]=this._z,t[e+3]=this._w,t}fromBufferAttribute(t,e){return this._x=t.getX(e),this._y=t.getY(e),this._z=t.getZ(e),this._w=t.getW(e),this._onChangeCallback(),this}toJSON(){return this.toArray()}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._w}},q=class{static{this.prototype.isVector3=!0}constructor(t=0,e=0,n=0){this.x=t,this.y=e,this.z=n}set(t,e,n){return n===void 0&&(n=this.z),this.x=t,this.y=e,this.z=n,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;case 2:this.z=e;break;default:throw new Error("THREE.Vector3: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;default:throw new Error("THREE.Vector3: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this.z=t.z+e.z,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this.z+=t.z*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this.z=t.z-e.z,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this}multiplyVectors(t,e){return this.x=t.x*e.x,this.y=t.y*e.y,this.z=t.z*e.z,this}applyEuler(t){return this.applyQuaternion(gg.setFromEuler(t))}applyAxisAngle(t,e){return this.applyQuaternion(gg.setFromAxisAngle(t,e))}applyMatrix3(t){let e=this.x,n=this.y,s=this.z,r=t.elements;return this.x=r[0]*e+r[3]*n+r[6]*s,this.y=r[1]*e+r[4]*n+r[7]*s,this.z=r[2]*e+r[5]*n+r[8]*s,this}applyNormalMatrix(t){return this.applyMatrix3(t).normalize()}applyMatrix4(t){let e=this.x,n=this.y,s=this.z,r=t.elements,o=1/(r[3]*e+r[7]*n+r[11]*s+r[15]);return this.x=(r[0]*e+r[4]*n+r[8]*s+r[12])*o,this.y=(r[1]*e+r[5]*n+r[9]*s+r[13])*o,this.z=(r[2]*e+r[6]*n+r[10]*s+r[14])*o,this}applyQuaternion(t){let e=this.x,n=this.y,s=this.z,r=t.x,o=t.y,a=t.z,l=t.w,c=2*(o*s-a*n),h=2*(a*e-r*s),f=2*(r*n-o*e);return this.x=e+l*c+o*f-a*h,this.y=n+l*h+a*c-r*f,this.z=s+l*f+r*h-o*c,this}project(t){return this.applyMatrix4(t.matrixWorldInverse).applyMatrix4(t.projectionMatrix)}unproject(t){return this.applyMatrix4(t.projectionMatrixInverse).applyMatrix4(t.matrixWorld)}transformDirection(t){let e=this.x,n=this.y,s=this.z,r=t.elements;return this.x=r[0]*e+r[4]*n+r[8]*s,this.y=r[1]*e+r[5]*n+r[9]*s,this.z=r[2]*e+r[6]*n+r[10]*s,this.normalize()}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this}divideScalar(t){return this.multiplyScalar(1/t)}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this}clamp(t,e){return this.x=ye(this.x,t.x,e.x),this.y=ye(this.y,t.y,e.y),this.z=ye(this.z,t.z,e.z),this}clampScalar(t,e){return this.x=ye(this.x,t,e),this.y=ye(this.y,t,e),this.z=ye(this.z,t,e),this}clampLength(t,e){let n=this.length();return this.divideScalar(n||1).multiplyScalar(ye(n,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this.z+=(t.z-this.z)*e,this}lerpVectors(t,e,n){return this.x=t.x+(e.x-t.x)*n,this.y=t.y+(e.y-t.y)*n,this.z=t.z+(e.z-t.z)*n,this}cross(t){return this.crossVectors(this,t)}crossVectors(t,e){let n=t.x,s=t.y,r=t.z,o=e.x,a=e.y,l=e.z;return this.x=s*l-r*a,this.y=r*o-n*l,this.z=n*a-s*o,this}projectOnVector(t){let e=t.lengthSq();if(e===0)return this.set(0,0,0);let n=t.dot(this)/e;return this.copy(t).multiplyScalar(n)}projectOnPlane(t){return of.copy(this).projectOnVector(t),this.sub(of)}reflect(t){return this.sub(of.copy(t).multiplyScalar(2*this.dot(t)))}angleTo(t){let e=Math.sqrt(this.lengthSq()*t.lengthSq());if(e===0)return Math.PI/2;let n=this.dot(t)/e;return Math.acos(ye(n,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let e=this.x-t.x,n=this.y-t.y,s=this.z-t.z;return e*e+n*n+s*s}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)+Math.abs(this.z-t.z)}setFromSpherical(t){return this.setFromSphericalCoords(t.radius,t.phi,t.theta)}setFromSphericalCoords(t,e,n){let s=Math.sin(e)*t;return this.x=s*Math.sin(n),this.y=Math.cos(e)*t,this.z=s*Math.cos(n),this}setFromCylindrical(t){return this.setFromCylindricalCoords(t.radius,t.theta,t.y)}setFromCylindricalCoords(t,e,n){return this.x=t*Math.sin(e),this.y=n,this.z=t*Math.cos(e),this}setFromMatrixPosition(t){let e=t.elements;return this.x=e[12],this.y=e[13],this.z=e[14],this}setFromMatrixScale(t){let e=this.setFromMatrixColumn(t,0).length(),n=this.setFromMatrixColumn(t,1).length(),s=this.setFromMatrixColumn(t,2).length();return this.x=e,this.y=n,this.z=s,this}setFromMatrixColumn(t,e){return this.fromArray(t.elements,e*4)}setFromMatrix3Column(t,e){return this.fromArray(t.elements,e*3)}setFromEuler(t){return this.x=t._x,this.y=t._y,this.z=t._z,this}setFromColor(t){return this.x=t.r,this.y=t.g,this.z=t.b,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this.z=t[e+2],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t[e+2]=this.z,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this.z=t.getZ(e),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this}randomDirection(){let t=Math.random()*Math.PI*2,e=Math.random()*2-1,n=Math.sqrt(1-e*e);return this.x=n*Math.cos(t),this.y=e,this.z=n*Math.sin(t),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z}},of=new q,gg=new Ji,ie=class{static{this.prototype.isMatrix3=!0}constructor(t,e,n,s,r,o,a,l,c){this.elements=[1,0,0,0,1,0,0,0,1],t!==void 0&&this.set(t,e,n,s,r,o,a,l,c)}set(t,e,n,s,r,o,a,l,c){let h=this.elements;return h[0]=t,h[1]=s,h[2]=a,h[3]=e,h[4]=r,h[5]=l,h[6]=n,h[7]=o,h[8]=c,this}identity(){return this.set(1,0,0,0,1,0,0,0,1),this}copy(t){let e=this.elements,n=t.elements;return e[0]=n[0],e[1]=n[1],e[2]=n[2],e[3]=n[3],e[4]=n[4],e[5]=n[5],e[6]=n[6],e[7]=n[7],e[8]=n[8],this}extractBasis(t,e,n){return t.setFromMatrix3Column(this,0),e.setFromMatrix3Column(this,1),n.setFromMatrix3Column(this,2),this}setFromMatrix4(t){let e=t.elements;return this.set(e[0],e[4],e[8],e[1],e[5],e[9],e[2],e[6],e[10]),this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,e){let n=t.elements,s=e.elements,r=this.elements,o=n[0],a=n[3],l=n[6],c=n[1],h=n[4],f=n[7],u=n[2],d=n[5],g=n[8],M=s[0],m=s[3],p=s[6],y=s[1],A=s[4],w=s[7],P=s[2],T=s[5],_=s[8];return r[0]=o*M+a*y+l*P,r[3]=o*m+a*A+l*T,r[6]=o*p+a*w+l*_,r[1]=c*M+h*y+f*P,r[4]=c*m+h*A+f*T,r[7]=c*p+h*w+f*_,r[2]=u*M+d*y+g*P,r[5]=u*m+d*A+g*T,r[8]=u*p+d*w+g*_,this}multiplyScalar(t){let e=this.elements;return e[0]*=t,e[3]*=t,e[6]*=t,e[1]*=t,e[4]*=t,e[7]*=t,e[2]*=t,e[5]*=t,e[8]*=t,this}determinant(){let t=this.elements,e=t[0],n=t[1],s=t[2],r=t[3],o=t[4],a=t[5],l=t[6],c=t[7],h=t[8];return e*o*h-e*a*c-n*r*h+n*a*l+s*r*c-s*o*l}invert(){let t=this.elements,e=t[0],n=t[1],s=t[2],r=t[3],o=t[4],a=t[5],l=t[6],c=t[7],h=t[8],f=h*o-a*c,u=a*l-h*r,d=c*r-o*l,g=e*f+n*u+s*d;if(g===0)return this.set(0,0,0,0,0,0,0,0,0);let M=1/g;return t[0]=f*M,t[1]=(s*c-h*n)*M,t[2]=(a*n-s*o)*M,t[3]=u*M,t[4]=(h*e-s*l)*M,t[5]=(s*r-a*e)*M,t[6]=d*M,t[7]=(n*l-c*e)*M,t[8]=(o*e-n*r)*M,this}transpose(){let t,e=this.elements;return t=e[1],e[1]=e[3],e[3]=t,t=e[2],e[2]=e[6],e[6]=t,t=e[5],e[5]=e[7],e[7]=t,this}getNormalMatrix(t){return this.setFromMatrix4(t).invert().transpose()}transposeIntoArray(t){let e=this.elements;return t[0]=e[0],t[1]=e[3],t[2]=e[6],t[3]=e[1],t[4]=e[4],t[5]=e[7],t[6]=e[2],t[7]=e[5],t[8]=e[8],this}setUvTransform(t,e,n,s,r,o,a){let l=Math.cos(r),c=Math.sin(r);return this.set(n*l,n*c,-n*(l*o+c*a)+o+t,-s*c,s*l,-s*(-c*o+l*a)+a+e,0,0,1),this}scale(t,e){return Jo("Matrix3: .scale() is deprecated. Use .makeScale() instead."),this.premultiply(af.makeScale(t,e)),this}rotate(t){return Jo("Matrix3: .rotate() is deprecated. Use .makeRotation() instead."),this.premultiply(af.makeRotation(-t)),this}translate(t,e){return Jo("Matrix3: .translate() is deprecated. Use .makeTranslation() instead."),this.premultiply(af.makeTranslation(t,e)),this}makeTranslation(t,e){return t.isVector2?this.set(1,0,t.x,0,1,t.y,0,0,1):this.set(1,0,t,0,1,e,0,0,1),this}makeRotation(t){let e=Math.cos(t),n=Math.sin(t);return this.set(e,-n,0,n,e,0,0,0,1),this}makeScale(t,e){return this.set(t,0,0,0,e,0,0,0,1),this}equals(t){let e=this.elements,n=t.elements;for(let s=0;s<9;s++)if(e[s]!==n[s])return!1;return!0}fromArray(t,e=0){for(let n=0;n<9;n++)this.elements[n]=t[n+e];return this}toArray(t=[],e=0){let n=this.elements;return t[e]=n[0],t[e+1]=n[1],t[e+2]=n[2],t[e+3]=n[3],t[e+4]=n[4],t[e+5]=n[5],t[e+6]=n[6],t[e+7]=n[7],t[e+8]=n[8],t}clone(){return new this.constructor().fromArray(this.elements)}},af=new ie,xg=new ie().set(.4123908,.3575843,.1804808,.212639,.7151687,.0721923,.0193308,.1191948,.9505322),_g=new ie().set(3.2409699,-1.5373832,-.4986108,-.9692436,1.8759675,.0415551,.0556301,-.203977,1.0569715);function Lb(){let i={enabled:!0,workingColorSpace:dr,spaces:{},convert:function(s,r,o){return this.enabled===!1||r===o||!r||!o||(this.spaces[r].transfer===Re&&(s.r=ps(s.r),s.g=ps(s.g),s.b=ps(s.b)),this.spaces[r].primaries!==this.spaces[o].primaries&&(s.applyMatrix3(this.spaces[r].toXYZ),s.applyMatrix3(this.spaces[o].fromXYZ)),this.spaces[o].transfer===Re&&(s.r=ho(s.r),s.g=ho(s.g),s.b=ho(s.b))),s},workingToColorSpace:function(s,r){return this.convert(s,this.workingColorSpace,r)},colorSpaceToWorking:function(s,r){return this.convert(s,r,this.workingColorSpace)},getPrimaries:function(s){return this.spaces[s].primaries},getTransfer:function(s){return s===vs?jo:this.spaces[s].transfer},getToneMappingMode:function(s){return this.spaces[s].outputColorSpaceConfig.toneMappingMode||"standard"},getLuminanceCoefficients:function(s,r=this.workingColorSpace){return s.fromArray(this.spaces[r].luminanceCoefficients)},define:function(s){Object.assign(this.spaces,s)},_getMatrix:function(s,r,o){return s.copy(this.spaces[o].fromXYZ).multiply(this.spaces[r].toXYZ)},_getDrawingBufferColorSpace:function(s){return this.spaces[s].outputColorSpaceConfig.drawingBufferColorSpace},_getUnpackColorSpace:function(s=this.workingColorSpace){return this.spaces[s].workingColorSpaceConfig.unpackColorSpace}},t=[.64,.33,.3,.6,.15,.06],e=[.2126,.7152,.0722],n=[.3127,.329];return i.define({[dr]:{primaries:t,whitePoint:n,transfer:jo,toXYZ:xg,fromXYZ:_g,luminanceCoefficients:e,workingColorSpaceConfig:{unpackColorSpace:li},outputColorSpaceConfig:{drawingBufferColorSpace:li}},[li]:{primaries:t,whitePoint:n,transfer:Re,toXYZ:xg,fromXYZ:_g,luminanceCoefficients:e,outputColorSpaceConfig:{drawingBufferColorSpace:li}}}),i}var ge=Lb();function ps(i){return i<.04045?i*.0773993808:Math.pow(i*.9478672986+.0521327014,2.4)}function ho(i){return i<.0031308?i*12.92:1.055*Math.pow(i,.41666)-.055}var Kr,lc=class{static getDataURL(t,e="image/png"){if(/^data:/i.test(t.src)||typeof HTMLCanvasElement>"u")return t.src;let n;if(t instanceof HTMLCanvasElement)n=t;else{Kr===void 0&&(Kr=ta("canvas")),Kr.width=t.width,Kr.height=t.height;let s=Kr.getContext("2d");t instanceof ImageData?s.putImageData(t,0,0):s.drawImage(t,0,0,t.width,t.height),n=Kr}return n.toDataURL(e)}static sRGBToLinear(t){if(typeof HTMLImageElement<"u"&&t instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&t instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&t instanceof ImageBitmap){let e=ta("canvas");e.width=t.width,e.height=t.height;let n=e.getContext("2d");n.drawImage(t,0,0,t.width,t.height);let s=n.getImageData(0,0,t.width,t.height),r=s.data;for(let o=0;o<r.length;o++)r[o]=ps(r[o]/255)*255;return n.putImageData(s,0,0),e}else if(t.data){let e=t.data.slice(0);for(let n=0;n<e.length;n++)e instanceof Uint8Array||e instanceof Uint8ClampedArray?e[n]=Math.floor(ps(e[n]/255)*255):e[n]=ps(e[n]);return{data:e,width:t.width,height:t.height}}else return jt("ImageUtils.sRGBToLinear(): Unsupported image type. No color space conversion applied."),t}},Nb=0,po=class{constructor(t=null){this.isTextureSource=!0,Object.defineProperty(this,"id",{value:Nb++}),this.uuid=Mr(),this.data=t,this.dataReady=!0,this.version=0}getSize(t){let e=this.data;return typeof HTMLVideoElement<"u"&&e instanceof HTMLVideoElement?t.set(e.videoWidth,e.videoHeight,0):typeof VideoFrame<"u"&&e instanceof VideoFrame?t.set(e.displayWidth,e.displayHeight,0):e!==null?t.set(e.width||0,e.height||0,e.depth||0):t.set(0,0,0),t}set needsUpdate(t){t===!0&&this.version++}toJSON(t){let e=t===void 0||typeof t=="string";if(!e&&t.images[this.uuid]!==void 0)return t.images[this.uuid];let n={uuid:this.uuid,url:""},s=this.data;if(s!==null){let r;if(Array.isArray(s)){r=[];for(let o=0,a=s.length;o<a;o++)s[o].isDataTexture?r.push(lf(s[o].image)):r.push(lf(s[o]))}else r=lf(s);n.url=r}return e||(t.images[this.uuid]=n),n}};function lf(i){return typeof HTMLImageElement<"u"&&i instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&i instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&i instanceof ImageBitmap?lc.getDataURL(i):i.data?{data:Array.from(i.data),width:i.width,height:i.height,type:i.data.constructor.name}:(jt("Texture: Unable to serialize Texture."),{})}var Db=0,cf=new q,Jn=class i extends Zi{constructor(t=i.DEFAULT_IMAGE,e=i.DEFAULT_MAPPING,n=Yi,s=Yi,r=Zn,o=xs,a=Ui,l=fi,c=i.DEFAULT_ANISOTROPY,h=vs){super(),this.isTexture=!0,Object.defineProperty(this,"id",{value:Db++}),this.uuid=Mr(),this.name="",this.source=new po(t),this.mipmaps=[],this.mapping=e,this.channel=0,this.wrapS=n,this.wrapT=s,this.magFilter=r,this.minFilter=o,this.anisotropy=c,this.format=a,this.internalFormat=null,this.type=l,this.offset=new Jt(0,0),this.repeat=new Jt(1,1),this.center=new Jt(0,0),this.rotation=0,this.matrixAutoUpdate=!0,this.matrix=new ie,this.generateMipmaps=!0,this.mipmapsAutoUpdate=!0,this.premultiplyAlpha=!1,this.flipY=!0,this.unpackAlignment=4,this.colorSpace=h,this.userData={},this.updateRanges=[],this.version=0,this.onUpdate=null,this.renderTarget=null,this.isRenderTargetTexture=!1,this.isArrayTexture=!!(t&&t.depth&&t.depth>1),this.pmremVersion=0,this.isPMREMTexture=!1,this.normalized=!1}get width(){return this.source.getSize(cf).x}get height(){return this.source.getSize(cf).y}get depth(){return this.source.getSize(cf).z}get image(){return this.source.data}set image(t){this.source.data=t}updateMatrix(){this.matrix.setUvTransform(this.offset.x,this.offset.y,this.repeat.x,this.repeat.y,this.rotation,this.center.x,this.center.y)}addUpdateRange(t,e){this.updateRanges.push({start:t,count:e})}clearUpdateRanges(){this.updateRanges.length=0}clone(){return new this.constructor().copy(this)}copy(t){return this.name=t.name,this.source=t.source,this.mipmaps=t.mipmaps.slice(0),this.mapping=t.mapping,this.channel=t.channel,this.wrapS=t.wrapS,this.wrapT=t.wrapT,this.magFilter=t.magFilter,this.minFilter=t.minFilter,this.anisotropy=t.anisotropy,this.format=t.format,this.internalFormat=t.internalFormat,this.type=t.type,this.normalized=t.normalized,this.offset.copy(t.offset),this.repeat.copy(t.repeat),this.center.copy(t.center),this.rotation=t.rotation,this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrix.copy(t.matrix),this.generateMipmaps=t.generateMipmaps,this.mipmapsAutoUpdate=t.mipmapsAutoUpdate,this.premultiplyAlpha=t.premultiplyAlpha,this.flipY=t.flipY,this.unpackAlignment=t.unpackAlignment,this.colorSpace=t.colorSpace,this.renderTarget=t.renderTarget,this.isRenderTargetTexture=t.isRenderTargetTexture,this.isPMREMTexture=t.isPMREMTexture,this.isArrayTexture=t.isArrayTexture,this.userData=JSON.parse(JSON.stringify(t.userData)),this.needsUpdate=!0,this}setValues(t){for(let e in t){let n=t[e];if(n===void 0){jt(`Texture.setValues(): parameter '${e}' has value of undefined.`);continue}let s=this[e];if(s===void 0){jt(`Texture.setValues(): property '${e}' does not exist.`);continue}s&&n&&s.isVector2&&n.isVector2||s&&n&&s.isVector3&&n.isVector3||s&&n&&s.isMatrix3&&n.isMatrix3?s.copy(n):this[e]=n}}toJSON(t){let e=t===void 0||typeof t=="string";if(!e&&t.textures[this.uuid]!==void 0)return t.textures[this.uuid];let n={metadata:{version:4.7,type:"Texture",generator:"Texture.toJSON"},uuid:this.uuid,name:this.name,image:this.source.toJSON(t).uuid,mapping:this.mapping,channel:this.channel,repeat:[this.repeat.x,this.repeat.y],offset:[this.offset.x,this.offset.y],center:[this.center.x,this.center.y],rotation:this.rotation,wrap:[this.wrapS,this.wrapT],format:this.format,internalFormat:this.internalFormat,type:this.type,normalized:this.normalized,colorSpace:this.colorSpace,minFilter:this.minFilter,magFilter:this.magFilter,anisotropy:this.anisotropy,flipY:this.flipY,generateMipmaps:this.generateMipmaps,mipmapsAutoUpdate:this.mipmapsAutoUpdate,premultiplyAlpha:this.premultiplyAlpha,unpackAlignment:this.unpackAlignment};return Object.keys(this.userData).length>0&&(n.userData=this.userData),e||(t.textures[this.uuid]=n),n}dispose(){this.dispatchEvent({type:"dispose"})}transformUv(t){if(this.mapping!==Xf)return t;if(t.applyMatrix3(this.matrix),t.x<0||t.x>1)switch(this.wrapS){case sc:t.x=t.x-Math.floor(t.x);break;case Yi:t.x=t.x<0?0:1;break;case rc:Math.abs(Math.floor(t.x)%2)===1?t.x=Math.ceil(t.x)-t.x:t.x=t.x-Math.floor(t.x);break}if(t.y<0||t.y>1)switch(this.wrapT){case sc:t.y=t.y-Math.floor(t.y);break;case Yi:t.y=t.y<0?0:1;break;case rc:Math.abs(Math.floor(t.y)%2)===1?t.y=Math.ceil(t.y)-t.y:t.y=t.y-Math.floor(t.y);break}return this.flipY&&(t.y=1-t.y),t}set needsUpdate(t){t===!0&&(this.version++,this.source.needsUpdate=!0)}set needsPMREMUpdate(t){t===!0&&this.pmremVersion++}};Jn.DEFAULT_IMAGE=null;Jn.DEFAULT_MAPPING=Xf;Jn.DEFAULT_ANISOTROPY=1;var qe=class{static{this.prototype.isVector4=!0}constructor(t=0,e=0,n=0,s=1){this.x=t,this.y=e,this.z=n,this.w=s}get width(){return this.z}set width(t){this.z=t}get height(){return this.w}set height(t){this.w=t}set(t,e,n,s){return this.x=t,this.y=e,this.z=n,this.w=s,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this.w=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setW(t){return this.w=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;case 2:this.z=e;break;case 3:this.w=e;break;default:throw new Error("THREE.Vector4: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;case 3:return this.w;default:throw new Error("THREE.Vector4: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z,this.w)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this.w=t.w!==void 0?t.w:1,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this.w+=t.w,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this.w+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this.z=t.z+e.z,this.w=t.w+e.w,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this.z+=t.z*e,this.w+=t.w*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this.w-=t.w,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this.w-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this.z=t.z-e.z,this.w=t.w-e.w,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this.w*=t.w,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this.w*=t,this}applyMatrix4(t){let e=this.x,n=this.y,s=this.z,r=this.w,o=t.elements;return this.x=o[0]*e+o[4]*n+o[8]*s+o[12]*r,this.y=o[1]*e+o[5]*n+o[9]*s+o[13]*r,this.z=o[2]*e+o[6]*n+o[10]*s+o[14]*r,this.w=o[3]*e+o[7]*n+o[11]*s+o[15]*r,this}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this.w/=t.w,this}divideScalar(t){return this.multiplyScalar(1/t)}setAxisAngleFromQuaternion(t){this.w=2*Math.acos(t.w);let e=Math.sqrt(1-t.w*t.w);return e<1e-4?(this.x=1,this.y=0,this.z=0):(this.x=t.x/e,this.y=t.y/e,this.z=t.z/e),this}setAxisAngleFromRotationMatrix(t){let e,n,s,r,l=t.elements,c=l[0],h=l[4],f=l[8],u=l[1],d=l[5],g=l[9],M=l[2],m=l[6],p=l[10];if(Math.abs(h-u)<.01&&Math.abs(f-M)<.01&&Math.abs(g-m)<.01){if(Math.abs(h+u)<.1&&Math.abs(f+M)<.1&&Math.abs(g+m)<.1&&Math.abs(c+d+p-3)<.1)return this.set(1,0,0,0),this;e=Math.PI;let A=(c+1)/2,w=(d+1)/2,P=(p+1)/2,T=(h+u)/4,_=(f+M)/4,E=(g+m)/4;return A>w&&A>P?A<.01?(n=0,s=.707106781,r=.707106781):(n=Math.sqrt(A),s=T/n,r=_/n):w>P?w<.01?(n=.707106781,s=0,r=.707106781):(s=Math.sqrt(w),n=T/s,r=E/s):P<.01?(n=.707106781,s=.707106781,r=0):(r=Math.sqrt(P),n=_/r,s=E/r),this.set(n,s,r,e),this}let y=Math.sqrt((m-g)*(m-g)+(f-M)*(f-M)+(u-h)*(u-h));return Math.abs(y)<.001&&(y=1),this.x=(m-g)/y,this.y=(f-M)/y,this.z=(u-h)/y,this.w=Math.acos((c+d+p-1)/2),this}setFromMatrixPosition(t){let e=t.elements;return this.x=e[12],this.y=e[13],this.z=e[14],this.w=e[15],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this.w=Math.min(this.w,t.w),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this.w=Math.max(this.w,t.w),this}clamp(t,e){return this.x=ye(this.x,t.x,e.x),this.y=ye(this.y,t.y,e.y),this.z=ye(this.z,t.z,e.z),this.w=ye(this.w,t.w,e.w),this}clampScalar(t,e){return this.x=ye(this.x,t,e),this.y=ye(this.y,t,e),this.z=ye(this.z,t,e),this.w=ye(this.w,t,e),this}clampLength(t,e){let n=this.length();return this.divideScalar(n||1).multiplyScalar(ye(n,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this.w=Math.floor(this.w),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this.w=Math.ceil(this.w),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this.w=Math.round(this.w),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this.w=Math.trunc(this.w),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this.w=-this.w,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z+this.w*t.w}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)+Math.abs(this.w)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this.z+=(t.z-this.z)*e,this.w+=(t.w-this.w)*e,this}lerpVectors(t,e,n){return this.x=t.x+(e.x-t.x)*n,this.y=t.y+(e.y-t.y)*n,this.z=t.z+(e.z-t.z)*n,this.w=t.w+(e.w-t.w)*n,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z&&t.w===this.w}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this.z=t[e+2],this.w=t[e+3],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t[e+2]=this.z,t[e+3]=this.w,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this.z=t.getZ(e),this.w=t.getW(e),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this.w=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z,yield this.w}},cc=class extends Zi{constructor(t=1,e=1,n={}){super(),n=Object.assign({generateMipmaps:!1,internalFormat:null,minFilter:Zn,depthBuffer:!0,stencilBuffer:!1,resolveColorBuffer:!0,resolveDepthBuffer:!0,resolveStencilBuffer:!0,storeMultisampledColorBuffer:!0,storeMultisampledDepthBuffer:!0,storeMultisampledStencilBuffer:!0,depthTexture:null,samples:0,count:1,depth:1,multiview:!1,useArrayDepthTexture:!1},n),this.isRenderTarget=!0,this.width=t,this.height=e,this.depth=n.depth,this.scissor=new qe(0,0,t,e),this.scissorTest=!1,this.viewport=new qe(0,0,t,e),this.textures=[];let s=n.count;for(let r=0;r<s;r++)this.textures[r]=new Jn({width:t,height:e,depth:n.depth}),this.textures[r].isRenderTargetTexture=!0,this.textures[r].renderTarget=this;this._setTextureOptions(n),this.depthBuffer=n.depthBuffer,this.stencilBuffer=n.stencilBuffer,this.resolveColorBuffer=n.resolveColorBuffer,this.resolveDepthBuffer=n.resolveDepthBuffer,this.resolveStencilBuffer=n.resolveStencilBuffer,this.storeMultisampledColorBuffer=n.storeMultisampledColorBuffer,this.storeMultisampledDepthBuffer=n.storeMultisampledDepthBuffer,this.storeMultisampledStencilBuffer=n.storeMultisampledStencilBuffer,this._depthTexture=null,this.depthTexture=n.depthTexture,this.samples=n.samples,this.multiview=n.multiview,this.useArrayDepthTexture=n.useArrayDepthTexture}_setTextureOptions(t={}){let e={minFilter:Zn,generateMipmaps:!1,flipY:!1,internalFormat:null};t.mapping!==void 0&&(e.mapping=t.mapping),t.wrapS!==void 0&&(e.wrapS=t.wrapS),t.wrapT!==void 0&&(e.wrapT=t.wrapT),t.wrapR!==void 0&&(e.wrapR=t.wrapR),t.magFilter!==void 0&&(e.magFilter=t.magFilter),t.minFilter!==void 0&&(e.minFilter=t.minFilter),t.format!==void 0&&(e.format=t.format),t.type!==void 0&&(e.type=t.type),t.anisotropy!==void 0&&(e.anisotropy=t.anisotropy),t.colorSpace!==void 0&&(e.colorSpace=t.colorSpace),t.flipY!==void 0&&(e.flipY=t.flipY),t.generateMipmaps!==void 0&&(e.generateMipmaps=t.generateMipmaps),t.mipmapsAutoUpdate!==void 0&&(e.mipmapsAutoUpdate=t.mipmapsAutoUpdate),t.internalFormat!==void 0&&(e.internalFormat=t.internalFormat);for(let n=0;n<this.textures.length;n++)this.textures[n].setValues(e)}get texture(){return this.textures[0]}set texture(t){this.textures[0]=t}set depthTexture(t){this._depthTexture!==null&&this._depthTexture.renderTarget===this&&(this._depthTexture.renderTarget=null),t!==null&&t.renderTarget===null&&(t.renderTarget=this),this._depthTexture=t}get depthTexture(){return this._depthTexture}setSize(t,e,n=1){if(this.width!==t||this.height!==e||this.depth!==n){this.width=t,this.height=e,this.depth=n;for(let s=0,r=this.textures.length;s<r;s++)this.textures[s].image.width=t,this.textures[s].image.height=e,this.textures[s].image.depth=n,this.textures[s].isData3DTexture!==!0&&(this.textures[s].isArrayTexture=this.textures[s].image.depth>1);this.dispose()}this.viewport.set(0,0,t,e),this.scissor.set(0,0,t,e)}clone(){return new this.constructor().copy(this)}copy(t){this.width=t.width,this.height=t.height,this.depth=t.depth,this.scissor.copy(t.scissor),this.scissorTest=t.scissorTest,this.viewport.copy(t.viewport),this.textures.length=0;for(let e=0,n=t.textures.length;e<n;e++){this.textures[e]=t.textures[e].clone(),this.textures[e].isRenderTargetTexture=!0,this.textures[e].renderTarget=this;let s=Object.assign({},t.textures[e].image);this.textures[e].source=new po(s)}if(this.depthBuffer=t.depthBuffer,this.stencilBuffer=t.stencilBuffer,this.resolveColorBuffer=t.resolveColorBuffer,this.resolveDepthBuffer=t.resolveDepthBuffer,this.resolveStencilBuffer=t.resolveStencilBuffer,this.storeMultisampledColorBuffer=t.storeMultisampledColorBuffer,this.storeMultisampledDepthBuffer=t.storeMultisampledDepthBuffer,this.storeMultisampledStencilBuffer=t.storeMultisampledStencilBuffer,t.depthTexture!==null)if(t.depthTexture.renderTarget===t){let e=t.depthTexture.clone();e.renderTarget=null,this.depthTexture=e}else this.depthTexture=t.depthTexture;else this.depthTexture=null;return this.samples=t.samples,this.multiview=t.multiview,this.useArrayDepthTexture=t.useArrayDepthTexture,this}dispose(){this.dispatchEvent({type:"dispose"})}},ci=class extends cc{constructor(t=1,e=1,n={}){super(t,e,n),this.isWebGLRenderTarget=!0}},na=class extends Jn{constructor(t=null,e=1,n=1,s=1){super(null),this.isDataArrayTexture=!0,this.image={data:t,width:e,height:n,depth:s},this.magFilter=on,this.minFilter=on,this.wrapR=Yi,this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1,this.layerUpdates=new Set}copy(t){return super.copy(t),this.wrapR=t.wrapR,this}addLayerUpdate(t){this.layerUpdates.add(t)}clearLayerUpdates(){this.layerUpdates.clear()}};var hc=class extends Jn{constructor(t=null,e=1,n=1,s=1){super(null),this.isData3DTexture=!0,this.image={data:t,width:e,height:n,depth:s},this.magFilter=on,this.minFilter=on,this.wrapR=Yi,this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1}copy(t){return super.copy(t),this.wrapR=t.wrapR,this}};var Ke=class i{static{this.prototype.isMatrix4=!0}constructor(t,e,n,s,r,o,a,l,c,h,f,u,d,g,M,m){this.elements=[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],t!==void 0&&this.set(t,e,n,s,r,o,a,l,c,h,f,u,d,g,M,m)}set(t,e,n,s,r,o,a,l,c,h,f,u,d,g,M,m){let p=this.elements;return p[0]=t,p[4]=e,p[8]=n,p[12]=s,p[1]=r,p[5]=o,p[9]=a,p[13]=l,p[2]=c,p[6]=h,p[10]=f,p[14]=u,p[3]=d,p[7]=g,p[11]=M,p[15]=m,this}identity(){return this.set(1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1),this}clone(){return new i().fromArray(this.elements)}copy(t){let e=this.elements,n=t.elements;return e[0]=n[0],e[1]=n[1],e[2]=n[2],e[3]=n[3],e[4]=n[4],e[5]=n[5],e[6]=n[6],e[7]=n[7],e[8]=n[8],e[9]=n[9],e[10]=n[10],e[11]=n[11],e[12]=n[12],e[13]=n[13],e[14]=n[14],e[15]=n[15],this}copyPosition(t){let e=this.elements,n=t.elements;return e[12]=n[12],e[13]=n[13],e[14]=n[14],this}setFromMatrix3(t){let e=t.elements;return this.set(e[0],e[3],e[6],0,e[1],e[4],e[7],0,e[2],e[5],e[8],0,0,0,0,1),this}extractBasis(t,e,n){return this.determinantAffine()===0?(t.set(1,0,0),e.set(0,1,0),n.set(0,0,1),this):(t.setFromMatrixColumn(this,0),e.setFromMatrixColumn(this,1),n.setFromMatrixColumn(this,2),this)}makeBasis(t,e,n){return this.set(t.x,e.x,n.x,0,t.y,e.y,n.y,0,t.z,e.z,n.z,0,0,0,0,1),this}extractRotation(t){if(t.determinantAffine()===0)return this.identity();let e=this.elements,n=t.elements,s=1/jr.setFromMatrixColumn(t,0).length(),r=1/jr.setFromMatrixColumn(t,1).length(),o=1/jr.setFromMatrixColumn(t,2).length();return e[0]=n[0]*s,e[1]=n[1]*s,e[2]=n[2]*s,e[3]=0,e[4]=n[4]*r,e[5]=n[5]*r,e[6]=n[6]*r,e[7]=0,e[8]=n[8]*o,e[9]=n[9]*o,e[10]=n[10]*o,e[11]=0,e[12]=0,e[13]=0,e[14]=0,e[15]=1,this}makeRotationFromEuler(t){let e=this.elements,n=t.x,s=t.y,r=t.z,o=Math.cos(n),a=Math.sin(n),l=Math.cos(s),c=Math.sin(s),h=Math.cos(r),f=Math.sin(r);if(t.order==="XYZ"){let u=o*h,d=o*f,g=a*h,M=a*f;e[0]=l*h,e[4]=-l*f,e[8]=c,e[1]=d+g*c,e[5]=u-M*c,e[9]=-a*l,e[2]=M-u*c,e[6]=g+d*c,e[10]=o*l}else if(t.order==="YXZ"){let u=l*h,d=l*f,g=c*h,M=c*f;e[0]=u+M*a,e[4]=g*a-d,e[8]=o*c,e[1]=o*f,e[5]=o*h,e[9]=-a,e[2]=d*a-g,e[6]=M+u*a,e[10]=o*l}else if(t.order==="ZXY"){let u=l*h,d=l*f,g=c*h,M=c*f;e[0]=u-M*a,e[4]=-o*f,e[8]=g+d*a,e[1]=d+g*a,e[5]=o*h,e[9]=M-u*a,e[2]=-o*c,e[6]=a,e[10]=o*l}else if(t.order==="ZYX"){let u=o*h,d=o*f,g=a*h,M=a*f;e[0]=l*h,e[4]=g*c-d,e[8]=u*c+M,e[1]=l*f,e[5]=M*c+u,e[9]=d*c-g,e[2]=-c,e[6]=a*l,e[10]=o*l}else if(t.order==="YZX"){let u=o*l,d=o*c,g=a*l,M=a*c;e[0]=l*h,e[4]=M-u*f,e[8]=g*f+d,e[1]=f,e[5]=o*h,e[9]=-a*h,e[2]=-c*h,e[6]=d*f+g,e[10]=u-M*f}else if(t.order==="XZY"){let u=o*l,d=o*c,g=a*l,M=a*c;e[0]=l*h,e[4]=-f,e[8]=c*h,e[1]=u*f+M,e[5]=o*h,e[9]=d*f-g,e[2]=g*f-d,e[6]=a*h,e[10]=M*f+u}return e[3]=0,e[7]=0,e[11]=0,e[12]=0,e[13]=0,e[14]=0,e[15]=1,this}makeRotationFromQuaternion(t){return this.compose(Ub,t,Fb)}lookAt(t,e,n){let s=this.elements;return oi.subVectors(t,e),oi.lengthSq()===0&&(oi.z=1),oi.normalize(),Fs.crossVectors(n,oi),Fs.lengthSq()===0&&(Math.abs(n.z)===1?oi.x+=1e-4:oi.z+=1e-4,oi.normalize(),Fs.crossVectors(n,oi)),Fs.normalize(),Al.crossVectors(oi,Fs),s[0]=Fs.x,s[4]=Al.x,s[8]=oi.x,s[1]=Fs.y,s[5]=Al.y,s[9]=oi.y,s[2]=Fs.z,s[6]=Al.z,s[10]=oi.z,this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,e){let n=t.elements,s=e.elements,r=this.elements,o=n[0],a=n[4],l=n[8],c=n[12],h=n[1],f=n[5],u=n[9],d=n[13],g=n[2],M=n[6],m=n[10],p=n[14],y=n[3],A=n[7],w=n[11],P=n[15],T=s[0],_=s[4],E=s[8],V=s[12],D=s[1],L=s[5],H=s[9],G=s[13],N=s[2],z=s[6],J=s[10],k=s[14],ct=s[3],K=s[7],Q=s[11],st=s[15];return r[0]=o*T+a*D+l*N+c*ct,r[4]=o*_+a*L+l*z+c*K,r[8]=o*E+a*H+l*J+c*Q,r[12]=o*V+a*G+l*k+c*st,r[1]=h*T+f*D+u*N+d*ct,r[5]=h*_+f*L+u*z+d*K,r[9]=h*E+f*H+u*J+d*Q,r[13]=h*V+f*G+u*k+d*st,r[2]=g*T+M*D+m*N+p*ct,r[6]=g*_+M*L+m*z+p*K,r[10]=g*E+M*H+m*J+p*Q,r[14]=g*V+M*G+m*k+p*st,r[3]=y*T+A*D+w*N+P*ct,r[7]=y*_+A*L+w*z+P*K,r[11]=y*E+A*H+w*J+P*Q,r[15]=y*V+A*G+w*k+P*st,this}multiplyScalar(t){let e=this.elements;return e[0]*=t,e[4]*=t,e[8]*=t,e[12]*=t,e[1]*=t,e[5]*=t,e[9]*=t,e[13]*=t,e[2]*=t,e[6]*=t,e[10]*=t,e[14]*=t,e[3]*=t,e[7]*=t,e[11]*=t,e[15]*=t,this}determinant(){let t=this.elements,e=t[0],n=t[4],s=t[8],r=t[12],o=t[1],a=t[5],l=t[9],c=t[13],h=t[2],f=t[6],u=t[10],d=t[14],g=t[3],M=t[7],m=t[11],p=t[15],y=l*d-c*u,A=a*d-c*f,w=a*u-l*f,P=o*d-c*h,T=o*u-l*h,_=o*f-a*h;return e*(M*y-m*A+p*w)-n*(g*y-m*P+p*T)+s*(g*A-M*P+p*_)-r*(g*w-M*T+m*_)}determinantAffine(){let t=this.elements,e=t[0],n=t[4],s=t[8],r=t[1],o=t[5],a=t[9],l=t[2],c=t[6],h=t[10];return e*(o*h-a*c)-n*(r*h-a*l)+s*(r*c-o*l)}transpose(){let t=this.elements,e;return e=t[1],t[1]=t[4],t[4]=e,e=t[2],t[2]=t[8],t[8]=e,e=t[6],t[6]=t[9],t[9]=e,e=t[3],t[3]=t[12],t[12]=e,e=t[7],t[7]=t[13],t[13]=e,e=t[11],t[11]=t[14],t[14]=e,this}setPosition(t,e,n){let s=this.elements;return t.isVector3?(s[12]=t.x,s[13]=t.y,s[14]=t.z):(s[12]=t,s[13]=e,s[14]=n),this}invert(){let t=this.elements,e=t[0],n=t[1],s=t[2],r=t[3],o=t[4],a=t[5],l=t[6],c=t[7],h=t[8],f=t[9],u=t[10],d=t[11],g=t[12],M=t[13],m=t[14],p=t[15],y=e*a-n*o,A=e*l-s*o,w=e*c-r*o,P=n*l-s*a,T=n*c-r*a,_=s*c-r*l,E=h*M-f*g,V=h*m-u*g,D=h*p-d*g,L=f*m-u*M,H=f*p-d*M,G=u*p-d*m,N=y*G-A*H+w*L+P*D-T*V+_*E;if(N===0)return this.set(0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0);let z=1/N;return t[0]=(a*G-l*H+c*L)*z,t[1]=(s*H-n*G-r*L)*z,t[2]=(M*_-m*T+p*P)*z,t[3]=(u*T-f*_-d*P)*z,t[4]=(l*D-o*G-c*V)*z,t[5]=(e*G-s*D+r*V)*z,t[6]=(m*w-g*_-p*A)*z,t[7]=(h*_-u*w+d*A)*z,t[8]=(o*H-a*D+c*E)*z,t[9]=(n*D-e*H-r*E)*z,t[10]=(g*T-M*w+p*y)*z,t[11]=(f*w-h*T-d*y)*z,t[12]=(a*V-o*L-l*E)*z,t[13]=(e*L-n*V+s*E)*z,t[14]=(M*A-g*P-m*y)*z,t[15]=(h*P-f*A+u*y)*z,this}scale(t){let e=this.elements,n=t.x,s=t.y,r=t.z;return e[0]*=n,e[4]*=s,e[8]*=r,e[1]*=n,e[5]*=s,e[9]*=r,e[2]*=n,e[6]*=s,e[10]*=r,e[3]*=n,e[7]*=s,e[11]*=r,this}getMaxScaleOnAxis(){let t=this.elements,e=t[0]*t[0]+t[1]*t[1]+t[2]*t[2],n=t[4]*t[4]+t[5]*t[5]+t[6]*t[6],s=t[8]*t[8]+t[9]*t[9]+t[10]*t[10];return Math.sqrt(Math.max(e,n,s))}makeTranslation(t,e,n){return t.isVector3?this.set(1,0,0,t.x,0,1,0,t.y,0,0,1,t.z,0,0,0,1):this.set(1,0,0,t,0,1,0,e,0,0,1,n,0,0,0,1),this}makeRotationX(t){let e=Math.cos(t),n=Math.sin(t);return this.set(1,0,0,0,0,e,-n,0,0,n,e,0,0,0,0,1),this}makeRotationY(t){let e=Math.cos(t),n=Math.sin(t);return this.set(e,0,n,0,0,1,0,0,-n,0,e,0,0,0,0,1),this}makeRotationZ(t){let e=Math.cos(t),n=Math.sin(t);return this.set(e,-n,0,0,n,e,0,0,0,0,1,0,0,0,0,1),this}makeRotationAxis(t,e){let n=Math.cos(e),s=Math.sin(e),r=1-n,o=t.x,a=t.y,l=t.z,c=r*o,h=r*a;return this.set(c*o+n,c*a-s*l,c*l+s*a,0,c*a+s*l,h*a+n,h*l-s*o,0,c*l-s*a,h*l+s*o,r*l*l+n,0,0,0,0,1),this}makeScale(t,e,n){return this.set(t,0,0,0,0,e,0,0,0,0,n,0,0,0,0,1),this}makeShear(t,e,n,s,r,o){return this.set(1,n,r,0,t,1,o,0,e,s,1,0,0,0,0,1),this}compose(t,e,n){let s=this.elements,r=e._x,o=e._y,a=e._z,l=e._w,c=r+r,h=o+o,f=a+a,u=r*c,d=r*h,g=r*f,M=o*h,m=o*f,p=a*f,y=l*c,A=l*h,w=l*f,P=n.x,T=n.y,_=n.z;return s[0]=(1-(M+p))*P,s[1]=(d+w)*P,s[2]=(g-A)*P,s[3]=0,s[4]=(d-w)*T,s[5]=(1-(u+p))*T,s[6]=(m+y)*T,s[7]=0,s[8]=(g+A)*_,s[9]=(m-y)*_,s[10]=(1-(u+M))*_,s[11]=0,s[12]=t.x,s[13]=t.y,s[14]=t.z,s[15]=1,this}decompose(t,e,n){let s=this.elements;t.x=s[12],t.y=s[13],t.z=s[14];let r=this.determinantAffine();if(r===0)return n.set(1,1,1),e.identity(),this;let o=jr.set(s[0],s[1],s[2]).length(),a=jr.set(s[4],s[5],s[6]).length(),l=jr.set(s[8],s[9],s[10]).length();r<0&&(o=-o),Ri.copy(this);let c=1/o,h=1/a,f=1/l;return Ri.elements[0]*=c,Ri.elements[1]*=c,Ri.elements[2]*=c,Ri.elements[4]*=h,Ri.elements[5]*=h,Ri.elements[6]*=h,Ri.elements[8]*=f,Ri.elements[9]*=f,Ri.elements[10]*=f,e.setFromRotationMatrix(Ri),n.x=o,n.y=a,n.z=l,this}makePerspective(t,e,n,s,r,o,a=yi,l=!1){let c=this.elements,h=2*r/(e-t),f=2*r/(n-s),u=(e+t)/(e-t),d=(n+s)/(n-s),g,M;if(l)g=r/(o-r),M=o*r/(o-r);else if(a===yi)g=-(o+r)/(o-r),M=-2*o*r/(o-r);else if(a===Qo)g=-o/(o-r),M=-o*r/(o-r);else throw new Error("THREE.Matrix4.makePerspective(): Invalid coordinate system: "+a);return c[0]=h,c[4]=0,c[8]=u,c[12]=0,c[1]=0,c[5]=f,c[9]=d,c[13]=0,c[2]=0,c[6]=0,c[10]=g,c[14]=M,c[3]=0,c[7]=0,c[11]=-1,c[15]=0,this}makeOrthographic(t,e,n,s,r,o,a=yi,l=!1){let c=this.elements,h=2/(e-t),f=2/(n-s),u=-(e+t)/(e-t),d=-(n+s)/(n-s),g,M;if(l)g=1/(o-r),M=o/(o-r);else if(a===yi)g=-2/(o-r),M=-(o+r)/(o-r);else if(a===Qo)g=-1/(o-r),M=-r/(o-r);else throw new Error("THREE.Matrix4.makeOrthographic(): Invalid coordinate system: "+a);return c[0]=h,c[4]=0,c[8]=0,c[12]=u,c[1]=0,c[5]=f,c[9]=0,c[13]=d,c[2]=0,c[6]=0,c[10]=g,c[14]=M,c[3]=0,c[7]=0,c[11]=0,c[15]=1,this}equals(t){let e=this.elements,n=t.elements;for(let s=0;s<16;s++)if(e[s]!==n[s])return!1;return!0}fromArray(t,e=0){for(let n=0;n<16;n++)this.elements[n]=t[n+e];return this}toArray(t=[],e=0){let n=this.elements;return t[e]=n[0],t[e+1]=n[1],t[e+2]=n[2],t[e+3]=n[3],t[e+4]=n[4],t[e+5]=n[5],t[e+6]=n[6],t[e+7]=n[7],t[e+8]=n[8],t[e+9]=n[9],t[e+10]=n[10],t[e+11]=n[11],t[e+12]=n[12],t[e+13]=n[13],t[e+14]=n[14],t[e+15]=n[15],t}},jr=new q,Ri=new Ke,Ub=new q(0,0,0),Fb=new q(1,1,1),Fs=new q,Al=new q,oi=new q,vg=new Ke,yg=new Ji,Hs=class i{constructor(t=0,e=0,n=0,s=i.DEFAULT_ORDER){this.isEuler=!0,this._x=t,this._y=e,this._z=n,this._order=s}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get order(){return this._order}set order(t){this._order=t,this._onChangeCallback()}set(t,e,n,s=this._order){return this._x=t,this._y=e,this._z=n,this._order=s,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._order)}copy(t){return this._x=t._x,this._y=t._y,this._z=t._z,this._order=t._order,this._onChangeCallback(),this}setFromRotationMatrix(t,e=this._order,n=!0){let s=t.elements,r=s[0],o=s[4],a=s[8],l=s[1],c=s[5],h=s[9],f=s[2],u=s[6],d=s[10];switch(e){case"XYZ":this._y=Math.asin(ye(a,-1,1)),Math.abs(a)<.9999999?(this._x=Math.atan2(-h,d),this._z=Math.atan2(-o,r)):(this._x=Math.atan2(u,c),this._z=0);break;case"YXZ":this._x=Math.asin(-ye(h,-1,1)),Math.abs(h)<.9999999?(this._y=Math.atan2(a,d),this._z=Math.atan2(l,c)):(this._y=Math.atan2(-f,r),this._z=0);break;case"ZXY":this._x=Math.asin(ye(u,-1,1)),Math.abs(u)<.9999999?(this._y=Math.atan2(-f,d),this._z=Math.atan2(-o,c)):(this._y=0,this._z=Math.atan2(l,r));break;case"ZYX":this._y=Math.asin(-ye(f,-1,1)),Math.abs(f)<.9999999?(this._x=Math.atan2(u,d),this._z=Math.atan2(l,r)):(this._x=0,this._z=Math.atan2(-o,c));break;case"YZX":this._z=Math.asin(ye(l,-1,1)),Math.abs(l)<.9999999?(this._x=Math.atan2(-h,c),this._y=Math.atan2(-f,r)):(this._x=0,this._y=Math.atan2(a,d));break;case"XZY":this._z=Math.asin(-ye(o,-1,1)),Math.abs(o)<.9999999?(this._x=Math.atan2(u,c),this._y=Math.atan2(a,r)):(this._x=Math.atan2(-h,d),this._y=0);break;default:jt("Euler: .setFromRotationMatrix() encountered an unknown order: "+e)}return this._order=e,n===!0&&this._onChangeCallback(),this}setFromQuaternion(t,e,n){return vg.makeRotationFromQuaternion(t),this.setFromRotationMatrix(vg,e,n)}setFromVector3(t,e=this._order){return this.set(t.x,t.y,t.z,e)}reorder(t){return yg.setFromEuler(this),this.setFromQuaternion(yg,t)}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._order===this._order}fromArray(t){return this._x=t[0],this._y=t[1],this._z=t[2],t[3]!==void 0&&(this._order=t[3]),this._onChangeCallback(),this}toArray(t=[],e=0){return t[e]=this._x,t[e+1]=this._y,t[e+2]=this._z,t[e+3]=this._order,t}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._order}};Hs.DEFAULT_ORDER="XYZ";var ia=class{constructor(){this.mask=1}set(t){this.mask=(1<<t|0)>>>0}enable(t){this.mask|=1<<t|0}enableAll(){this.mask=-1}toggle(t){this.mask^=1<<t|0}disable(t){this.mask&=~(1<<t|0)}disableAll(){this.mask=0}test(t){return(this.mask&t.mask)!==0}isEnabled(t){return(this.mask&(1<<t|0))!==0}},Ob=0,bg=new q,Qr=new Ji,cs=new Ke,Rl=new q,qo=new q,Bb=new q,kb=new Ji,Sg=new q(1,0,0),Mg=new q(0,1,0),wg=new q(0,0,1),Eg={type:"added"},zb={type:"removed"},to={type:"childadded",child:null},hf={type:"childremoved",child:null},hi=class i extends Zi{constructor(){super(),this.isObject3D=!0,Object.defineProperty(this,"id",{value:Ob++}),this.uuid=Mr(),this.name="",this.type="Object3D",this.parent=null,this.children=[],this.up=i.DEFAULT_UP.clone();let t=new q,e=new Hs,n=new Ji,s=new q(1,1,1);function r(){n.setFromEuler(e,!1)}function o(){e.setFromQuaternion(n,void 0,!1)}e._onChange(r),n._onChange(o),Object.defineProperties(this,{position:{configurable:!0,enumerable:!0,value:t},rotation:{configurable:!0,enumerable:!0,value:e},quaternion:{configurable:!0,enumerable:!0,value:n},scale:{configurable:!0,enumerable:!0,value:s},modelViewMatrix:{value:new Ke},normalMatrix:{value:new ie}}),this.matrix=new Ke,this.matrixWorld=new Ke,this.matrixAutoUpdate=i.DEFAULT_MATRIX_AUTO_UPDATE,this.matrixWorldAutoUpdate=i.DEFAULT_MATRIX_WORLD_AUTO_UPDATE,this.matrixWorldNeedsUpdate=!1,this.layers=new ia,this.visible=!0,this.castShadow=!1,this.receiveShadow=!1,this.frustumCulled=!0,this.renderOrder=0,this.animations=[],this.customDepthMaterial=void 0,this.customDistanceMaterial=void 0,this.static=!1,this.userData={},this.pivot=null}onBeforeShadow(){}onAfterShadow(){}onBeforeRender(){}onAfterRender(){}applyMatrix4(t){this.matrixAutoUpdate&&this.updateMatrix(),this.matrix.premultiply(t),this.matrix.decompose(this.position,this.quaternion,this.scale),this.pivot!==null&&this.position.copy(this.pivot).applyMatrix4(this.matrix).sub(this.pivot)}applyQuaternion(t){return this.quaternion.premultiply(t),this}setRotationFromAxisAngle(t,e){this.quaternion.setFromAxisAngle(t,e)}setRotationFromEuler(t){this.quaternion.setFromEuler(t,!0)}setRotationFromMatrix(t){this.quaternion.setFromRotationMatrix(t)}setRotationFromQuaternion(t){this.quaternion.copy(t)}rotateOnAxis(t,e){return Qr.setFromAxisAngle(t,e),this.quaternion.multiply(Qr),this}rotateOnWorldAxis(t,e){return Qr.setFromAxisAngle(t,e),this.quaternion.premultiply(Qr),this}rotateX(t){return this.rotateOnAxis(Sg,t)}rotateY(t){return this.rotateOnAxis(Mg,t)}rotateZ(t){return this.rotateOnAxis(wg,t)}translateOnAxis(t,e){return bg.copy(t).applyQuaternion(this.quaternion),this.position.add(bg.multiplyScalar(e)),this}translateX(t){return this.translateOnAxis(Sg,t)}translateY(t){return this.translateOnAxis(Mg,t)}translateZ(t){return this.translateOnAxis(wg,t)}localToWorld(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(this.matrixWorld)}worldToLocal(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(cs.copy(this.matrixWorld).invert())}lookAt(t,e,n){t.isVector3?Rl.copy(t):Rl.set(t,e,n);let s=this.parent;this.updateWorldMatrix(!0,!1),qo.setFromMatrixPosition(this.matrixWorld),this.isCamera||this.isLight?cs.lookAt(qo,Rl,this.up):cs.lookAt(Rl,qo,this.up),this.quaternion.setFromRotationMatrix(cs),s&&(cs.extractRotation(s.matrixWorld),Qr.setFromRotationMatrix(cs),this.quaternion.premultiply(Qr.invert()))}add(t){if(arguments.length>1){for(let e=0;e<arguments.length;e++)this.add(arguments[e]);return this}return t===this?(ne("Object3D.add: object can't be added as a child of itself.",t),this):(t&&t.isObject3D?(t.removeFromParent(),t.parent=this,this.children.push(t),t.dispatchEvent(Eg),to.child=t,this.dispatchEvent(to),to.child=null):ne("Object3D.add: object not an instance of THREE.Object3D.",t),this)}remove(t){if(arguments.length>1){for(let n=0;n<arguments.length;n++)this.remove(arguments[n]);return this}let e=this.children.indexOf(t);return e!==-1&&(t.parent=null,this.children.splice(e,1),t.dispatchEvent(zb),hf.child=t,this.dispatchEvent(hf),hf.child=null),this}removeFromParent(){let t=this.parent;return t!==null&&t.remove(this),this}clear(){return this.remove(...this.children)}attach(t){return this.updateWorldMatrix(!0,!1),cs.copy(this.matrixWorld).invert(),t.parent!==null&&(t.parent.updateWorldMatrix(!0,!1),cs.multiply(t.parent.matrixWorld)),t.applyMatrix4(cs),t.removeFromParent(),t.parent=this,this.children.push(t),t.updateWorldMatrix(!1,!0),t.dispatchEvent(Eg),to.child=t,this.dispatchEvent(to),to.child=null,this}getObjectById(t){return this.getObjectByProperty("id",t)}getObjectByName(t){return this.getObjectByProperty("name",t)}getObjectByProperty(t,e){if(this[t]===e)return this;for(let n=0,s=this.children.length;n<s;n++){let o=this.children[n].getObjectByProperty(t,e);if(o!==void 0)return o}}getObjectsByProperty(t,e,n=[]){this[t]===e&&n.push(this);let s=this.children;for(let r=0,o=s.length;r<o;r++)s[r].getObjectsByProperty(t,e,n);return n}getWorldPosition(t){return this.updateWorldMatrix(!0,!1),t.setFromMatrixPosition(this.matrixWorld)}getWorldQuaternion(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(qo,t,Bb),t}getWorldScale(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(qo,kb,t),t}getWorldDirection(t){this.updateWorldMatrix(!0,!1);let e=this.matrixWorld.elements;return t.set(e[8],e[9],e[10]).normalize()}raycast(){}intersectsFrustum(){return!0}traverse(t){t(this);let e=this.children;for(let n=0,s=e.length;n<s;n++)e[n].traverse(t)}traverseVisible(t){if(this.visible===!1)return;t(this);let e=this.children;for(let n=0,s=e.length;n<s;n++)e[n].traverseVisible(t)}traverseAncestors(t){let e=this.parent;e!==null&&(t(e),e.traverseAncestors(t))}updateMatrix(){this.matrix.compose(this.position,this.quaternion,this.scale);let t=this.pivot;if(t!==null){let e=t.x,n=t.y,s=t.z,r=this.matrix.elements;r[12]+=e-r[0]*e-r[4]*n-r[8]*s,r[13]+=n-r[1]*e-r[5]*n-r[9]*s,r[14]+=s-r[2]*e-r[6]*n-r[10]*s}this.matrixWorldNeedsUpdate=!0}updateMatrixWorld(t){this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||t)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,t=!0);let e=this.children;for(let n=0,s=e.length;n<s;n++)e[n].updateMatrixWorld(t)}updateWorldMatrix(t,e,n=!1){let s=this.parent;if(t===!0&&s!==null&&s.updateWorldMatrix(!0,!1),this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||n)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,n=!0),e===!0){let r=this.children;for(let o=0,a=r.length;o<a;o++)r[o].updateWorldMatrix(!1,!0,n)}}toJSON(t){let e=t===void 0||typeof t=="string",n={};e&&(t={geometries:{},materials:{},textures:{},images:{},shapes:{},skeletons:{},animations:{},nodes:{}},n.metadata={version:4.7,type:"Object",generator:"Object3D.toJSON"});let s={};s.uuid=this.uuid,s.type=this.type,s.name=this.name,s.castShadow=this.castShadow,s.receiveShadow=this.receiveShadow,s.visible=this.visible,s.frustumCulled=this.frustumCulled,s.renderOrder=this.renderOrder,s.static=this.static,s.matrixAutoUpdate=this.matrixAutoUpdate,Object.keys(this.userData).length>0&&(s.userData=this.userData),s.layers=this.layers.mask,s.matrix=this.matrix.toArray(),s.up=this.up.toArray(),this.pivot!==null&&(s.pivot=this.pivot.toArray()),this.morphTargetDictionary!==void 0&&(s.morphTargetDictionary=Object.assign({},this.morphTargetDictionary)),this.morphTargetInfluences!==void 0&&(s.morphTargetInfluences=this.morphTargetInfluences.slice()),this.isInstancedMesh&&(s.type="InstancedMesh",s.count=this.count,s.instanceMatrix=this.instanceMatrix.toJSON(),this.instanceColor!==null&&(s.instanceColor=this.instanceColor.toJSON())),this.isBatchedMesh&&(s.type="BatchedMesh",s.perObjectFrustumCulled=this.perObjectFrustumCulled,s.sortObjects=this.sortObjects,s.drawRanges=this._drawRanges,s.reservedRanges=this._reservedRanges,s.geometryInfo=this._geometryInfo.map(a=>({...a,boundingBox:a.boundingBox?a.boundingBox.toJSON():void 0,boundingSphere:a.boundingSphere?a.boundingSphere.toJSON():void 0})),s.instanceInfo=this._instanceInfo.map(a=>({...a})),s.availableInstanceIds=this._availableInstanceIds.slice(),s.availableGeometryIds=this._availableGeometryIds.slice(),s.nextIndexStart=this._nextIndexStart,s.nextVertexStart=this._nextVertexStart,s.geometryCount=this._geometryCount,s.maxInstanceCount=this._maxInstanceCount,s.maxVertexCount=this._maxVertexCount,s.maxIndexCount=this._maxIndexCount,s.geometryInitialized=this._geometryInitialized,s.matricesTexture=this._matricesTexture.toJSON(t),s.indirectTexture=this._indirectTexture.toJSON(t),this._colorsTexture!==null&&(s.colorsTexture=this._colorsTexture.toJSON(t)),this.boundingSphere!==null&&(s.boundingSphere=this.boundingSphere.toJSON()),this.boundingBox!==null&&(s.boundingBox=this.boundingBox.toJSON()));function r(a,l){return a[l.uuid]===void 0&&(a[l.uuid]=l.toJSON(t)),l.uuid}if(this.isScene)this.background&&(this.background.isColor?s.background=this.background.toJSON():this.background.isTexture&&(s.background=this.background.toJSON(t).uuid)),this.environment&&this.environment.isTexture&&this.environment.isRenderTargetTexture!==!0&&(s.environment=this.environment.toJSON(t).uuid);else if(this.isMesh||this.isLine||this.isPoints){s.geometry=r(t.geometries,this.geometry);let a=this.geometry.parameters;if(a!==void 0&&a.shapes!==void 0){let l=a.shapes;if(Array.isArray(l))for(let c=0,h=l.length;c<h;c++){let f=l[c];r(t.shapes,f)}else r(t.shapes,l)}}if(this.isSkinnedMesh&&(s.bindMode=this.bindMode,s.bindMatrix=this.bindMatrix.toArray(),this.skeleton!==void 0&&(r(t.skeletons,this.skeleton),s.skeleton=this.skeleton.uuid)),this.material!==void 0)if(Array.isArray(this.material)){let a=[];for(let l=0,c=this.material.length;l<c;l++)a.push(r(t.materials,this.material[l]));s.material=a}else s.material=r(t.materials,this.material);if(this.children.length>0){s.children=[];for(let a=0;a<this.children.length;a++)s.children.push(this.children[a].toJSON(t).object)}if(this.animations.length>0){s.animations=[];for(let a=0;a<this.animations.length;a++){let l=this.animations[a];s.animations.push(r(t.animations,l))}}if(e){let a=o(t.geometries),l=o(t.materials),c=o(t.textures),h=o(t.images),f=o(t.shapes),u=o(t.skeletons),d=o(t.animations),g=o(t.nodes);a.length>0&&(n.geometries=a),l.length>0&&(n.materials=l),c.length>0&&(n.textures=c),h.length>0&&(n.images=h),f.length>0&&(n.shapes=f),u.length>0&&(n.skeletons=u),d.length>0&&(n.animations=d),g.length>0&&(n.nodes=g)}return n.object=s,n;function o(a){let l=[];for(let c in a){let h=a[c];delete h.metadata,l.push(h)}return l}}clone(t){return new this.constructor().copy(this,t)}copy(t,e=!0){if(this.name=t.name,this.up.copy(t.up),this.position.copy(t.position),this.rotation.order=t.rotation.order,this.quaternion.copy(t.quaternion),this.scale.copy(t.scale),this.pivot=t.pivot!==null?t.pivot.clone():null,this.matrix.copy(t.matrix),this.matrixWorld.copy(t.matrixWorld),this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrixWorldAutoUpdate=t.matrixWorldAutoUpdate,this.matrixWorldNeedsUpdate=t.matrixWorldNeedsUpdate,this.layers.mask=t.layers.mask,this.visible=t.visible,this.castShadow=t.castShadow,this.receiveShadow=t.receiveShadow,this.frustumCulled=t.frustumCulled,this.renderOrder=t.renderOrder,this.static=t.static,this.animations=t.animations.slice(),this.userData=JSON.parse(JSON.stringify(t.userData)),e===!0)for(let n=0;n<t.children.length;n++){let s=t.children[n];this.add(s.clone())}return this}dispose(){this.dispatchEvent({type:"dispose"})}};hi.DEFAULT_UP=new q(0,1,0);hi.DEFAULT_MATRIX_AUTO_UPDATE=!0;hi.DEFAULT_MATRIX_WORLD_AUTO_UPDATE=!0;var Yn=class extends hi{constructor(){super(),this.isGroup=!0,this.type="Group"}},Vb={type:"move"},mo=class{constructor(){this._targetRay=null,this._grip=null,this._hand=null}getHandSpace(){return this._hand===null&&(this._hand=new Yn,this._hand.matrixAutoUpdate=!1,this._hand.visible=!1,this._hand.joints={},this._hand.inputState={pinching:!1}),this._hand}getTargetRaySpace(){return this._targetRay===null&&(this._targetRay=new Yn,this._targetRay.matrixAutoUpdate=!1,this._targetRay.visible=!1,this._targetRay.hasLinearVelocity=!1,this._targetRay.linearVelocity=new q,this._targetRay.hasAngularVelocity=!1,this._targetRay.angularVelocity=new q),this._targetRay}getGripSpace(){return this._grip===null&&(this._grip=new Yn,this._grip.matrixAutoUpdate=!1,this._grip.visible=!1,this._grip.hasLinearVelocity=!1,this._grip.linearVelocity=new q,this._grip.hasAngularVelocity=!1,this._grip.angularVelocity=new q,this._grip.eventsEnabled=!1),this._grip}dispatchEvent(t){return this._targetRay!==null&&this._targetRay.dispatchEvent(t),this._grip!==null&&this._grip.dispatchEvent(t),this._hand!==null&&this._hand.dispatchEvent(t),this}connect(t){if(t&&t.hand){let e=this._hand;if(e)for(let n of t.hand.values())this._getHandJoint(e,n)}return this.dispatchEvent({type:"connected",data:t}),this}disconnect(t){return this.dispatchEvent({type:"disconnected",data:t}),this._targetRay!==null&&(this._targetRay.visible=!1),this._grip!==null&&(this._grip.visible=!1),this._hand!==null&&(this._hand.visible=!1),this}update(t,e,n){let s=null,r=null,o=null,a=this._targetRay,l=this._grip,c=this._hand;if(t&&e.session.visibilityState!=="visible-blurred"){if(c&&t.hand){o=!0;for(let M of t.hand.values()){let m=e.getJointPose(M,n),p=this._getHandJoint(c,M);m!==null&&(p.matrix.fromArray(m.transform.matrix),p.matrix.decompose(p.position,p.quaternion,p.scale),p.matrixWorldNeedsUpdate=!0,p.jointRadius=m.radius),p.visible=m!==null}let h=c.joints["index-finger-tip"],f=c.joints["thumb-tip"],u=h.position.distanceTo(f.position),d=.02,g=.005;c.inputState.pinching&&u>d+g?(c.inputState.pinching=!1,this.dispatchEvent({type:"pinchend",handedness:t.handedness,target:this})):!c.inputState.pinching&&u<=d-g&&(c.inputState.pinching=!0,this.dispatchEvent({type:"pinchstart",handedness:t.handedness,target:this}))}else l!==null&&t.gripSpace&&(r=e.getPose(t.gripSpace,n),r!==null&&(l.matrix.fromArray(r.transform.matrix),l.matrix.decompose(l.position,l.quaternion,l.scale),l.matrixWorldNeedsUpdate=!0,r.linearVelocity?(l.hasLinearVelocity=!0,l.linearVelocity.copy(r.linearVelocity)):l.hasLinearVelocity=!1,r.angularVelocity?(l.hasAngularVelocity=!0,l.angularVelocity.copy(r.angularVelocity)):l.hasAngularVelocity=!1,l.eventsEnabled&&l.dispatchEvent({type:"gripUpdated",data:t,target:this})));a!==null&&(s=e.getPose(t.targetRaySpace,n),s===null&&r!==null&&(s=r),s!==null&&(a.matrix.fromArray(s.transform.matrix),a.matrix.decompose(a.position,a.quaternion,a.scale),a.matrixWorldNeedsUpdate=!0,s.linearVelocity?(a.hasLinearVelocity=!0,a.linearVelocity.copy(s.linearVelocity)):a.hasLinearVelocity=!1,s.angularVelocity?(a.hasAngularVelocity=!0,a.angularVelocity.copy(s.angularVelocity)):a.hasAngularVelocity=!1,this.dispatchEvent(Vb)))}return a!==null&&(a.visible=s!==null),l!==null&&(l.visible=r!==null),c!==null&&(c.visible=o!==null),this}_getHandJoint(t,e){if(t.joints[e.jointName]===void 0){let n=new Yn;n.matrixAutoUpdate=!1,n.visible=!1,t.joints[e.jointName]=n,t.add(n)}return t.joints[e.jointName]}},M0={aliceblue:15792383,antiquewhite:16444375,aqua:65535,aquamarine:8388564,azure:15794175,beige:16119260,bisque:16770244,black:0,blanchedalmond:16772045,blue:255,blueviolet:9055202,brown:10824234,burlywood:14596231,cadetblue:6266528,chartreuse:8388352,chocolate:13789470,coral:16744272,cornflowerblue:6591981,cornsilk:16775388,crimson:14423100,cyan:65535,darkblue:139,darkcyan:35723,darkgoldenrod:12092939,darkgray:11119017,darkgreen:25600,darkgrey:11119017,darkkhaki:12433259,darkmagenta:9109643,darkolivegreen:5597999,darkorange:16747520,darkorchid:10040012,darkred:9109504,darksalmon:15308410,darkseagreen:9419919,darkslateblue:4734347,darkslategray:3100495,darkslategrey:3100495,darkturquoise:52945,darkviolet:9699539,deeppink:16716947,deepskyblue:49151,dimgray:6908265,dimgrey:6908265,dodgerblue:2003199,firebrick:11674146,floralwhite:16775920,forestgreen:2263842,fuchsia:16711935,gainsboro:14474460,ghostwhite:16316671,gold:16766720,goldenrod:14329120,gray:8421504,green:32768,greenyellow:11403055,grey:8421504,honeydew:15794160,hotpink:16738740,indianred:13458524,indigo:4915330,ivory:16777200,khaki:15787660,lavender:15132410,lavenderblush:16773365,lawngreen:8190976,lemonchiffon:16775885,lightblue:11393254,lightcoral:15761536,lightcyan:14745599,lightgoldenrodyellow:16448210,lightgray:13882323,lightgreen:9498256,lightgrey:13882323,lightpink:16758465,lightsalmon:16752762,lightseagreen:2142890,lightskyblue:8900346,lightslategray:7833753,lightslategrey:7833753,lightsteelblue:11584734,lightyellow:16777184,lime:65280,limegreen:3329330,linen:16445670,magenta:16711935,maroon:8388608,mediumaquamarine:6737322,mediumblue:205,mediumorchid:12211667,mediumpurple:9662683,mediumseagreen:3978097,mediumslateblue:8087790,mediumspringgreen:64154,mediumturquoise:4772300,mediumvioletred:13047173,midnightblue:1644912,mintcream:16121850,mistyrose:16770273,moccasin:16770229,navajowhite:16768685,navy:128,oldlace:16643558,olive:8421376,olivedrab:7048739,orange:16753920,orangered:16729344,orchid:14315734,palegoldenrod:15657130,palegreen:10025880,paleturquoise:11529966,palevioletred:14381203,papayawhip:16773077,peachpuff:16767673,peru:13468991,pink:16761035,plum:14524637,powderblue:11591910,purple:8388736,rebeccapurple:6697881,red:16711680,rosybrown:12357519,royalblue:4286945,saddlebrown:9127187,salmon:16416882,sandybrown:16032864,seagreen:3050327,seashell:16774638,sienna:10506797,silver:12632256,skyblue:8900331,slateblue:6970061,slategray:7372944,slategrey:7372944,snow:16775930,springgreen:65407,steelblue:4620980,tan:13808780,teal:32896,thistle:14204888,tomato:16737095,turquoise:4251856,violet:15631086,wheat:16113331,white:16777215,whitesmoke:16119285,yellow:16776960,yellowgreen:10145074},Os={h:0,s:0,l:0},Cl={h:0,s:0,l:0};function uf(i,t,e){return e<0&&(e+=1),e>1&&(e-=1),e<1/6?i+(t-i)*6*e:e<1/2?t:e<2/3?i+(t-i)*6*(2/3-e):i}var Yt=class{constructor(t,e,n){return this.isColor=!0,this.r=1,this.g=1,this.b=1,this.set(t,e,n)}set(t,e,n){if(e===void 0&&n===void 0){let s=t;s&&s.isColor?this.copy(s):typeof s=="number"?this.setHex(s):typeof s=="string"&&this.setStyle(s)}else this.setRGB(t,e,n);return this}setScalar(t){return this.r=t,this.g=t,this.b=t,this}setHex(t,e=li){return t=Math.floor(t),this.r=(t>>16&255)/255,this.g=(t>>8&255)/255,this.b=(t&255)/255,ge.colorSpaceToWorking(this,e),this}setRGB(t,e,n,s=ge.workingColorSpace){return this.r=t,this.g=e,this.b=n,ge.colorSpaceToWorking(this,s),this}setHSL(t,e,n,s=ge.workingColorSpace){if(t=Ib(t,1),e=ye(e,0,1),n=ye(n,0,1),e===0)this.r=this.g=this.b=n;else{let r=n<=.5?n*(1+e):n+e-n*e,o=2*n-r;this.r=uf(o,r,t+1/3),this.g=uf(o,r,t),this.b=uf(o,r,t-1/3)}return ge.colorSpaceToWorking(this,s),this}setStyle(t,e=li){function n(r){r!==void 0&&parseFloat(r)<1&&jt("Color: Alpha component of "+t+" will be ignored.")}let s;if(s=/^(\w+)\(([^\)]*)\)/.exec(t)){let r,o=s[1],a=s[2];switch(o){case"rgb":case"rgba":if(r=/^\s*(\d+)\s*,\s*(\d+)\s*,\s*(\d+)\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return n(r[4]),this.setRGB(Math.min(255,parseInt(r[1],10))/255,Math.min(255,parseInt(r[2],10))/255,Math.min(255,parseInt(r[3],10))/255,e);if(r=/^\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return n(r[4]),this.setRGB(Math.min(100,parseFloat(r[1]))/100,Math.min(100,parseFloat(r[2]))/100,Math.min(100,parseFloat(r[3]))/100,e);break;case"hsl":case"hsla":if(r=/^\s*([+-]?(?:\d+(?:\.\d+)?|\.\d+))\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return n(r[4]),this.setHSL(parseFloat(r[1])/360,parseFloat(r[2])/100,parseFloat(r[3])/100,e);break;default:jt("Color: Unknown color model "+t)}}else if(s=/^\#([A-Fa-f\d]+)$/.exec(t)){let r=s[1],o=r.length;if(o===3)return this.setRGB(parseInt(r.charAt(0),16)/15,parseInt(r.charAt(1),16)/15,parseInt(r.charAt(2),16)/15,e);if(o===6)return this.setHex(parseInt(r,16),e);jt("Color: Invalid hex color "+t)}else if(t&&t.length>0)return this.setColorName(t,e);return this}setColorName(t,e=li){let n=M0[t.toLowerCase()];return n!==void 0?this.setHex(n,e):jt("Color: Unknown color "+t),this}clone(){return new this.constructor(this.r,this.g,this.b)}copy(t){return this.r=t.r,this.g=t.g,this.b=t.b,this}copySRGBToLinear(t){return this.r=ps(t.r),this.g=ps(t.g),this.b=ps(t.b),this}copyLinearToSRGB(t){return this.r=ho(t.r),this.g=ho(t.g),this.b=ho(t.b),this}convertSRGBToLinear(){return this.copySRGBToLinear(this),this}convertLinearToSRGB(){return this.copyLinearToSRGB(this),this}getHex(t=li){return ge.workingToColorSpace(Un.copy(this),t),Math.round(ye(Un.r*255,0,255))*65536+Math.round(ye(Un.g*255,0,255))*256+Math.round(ye(Un.b*255,0,255))}getHexString(t=li){return("000000"+this.getHex(t).toString(16)).slice(-6)}getHSL(t,e=ge.workingColorSpace){ge.workingToColorSpace(Un.copy(this),e);let n=Un.r,s=Un.g,r=Un.b,o=Math.max(n,s,r),a=Math.min(n,s,r),l,c,h=(a+o)/2;if(a===o)l=0,c=0;else{let f=o-a;switch(c=h<=.5?f/(o+a):f/(2-o-a),o){case n:l=(s-r)/f+(s<r?6:0);break;case s:l=(r-n)/f+2;break;case r:l=(n-s)/f+4;break}l/=6}return t.h=l,t.s=c,t.l=h,t}getRGB(t,e=ge.workingColorSpace){return ge.workingToColorSpace(Un.copy(this),e),t.r=Un.r,t.g=Un.g,t.b=Un.b,t}getStyle(t=li){ge.workingToColorSpace(Un.copy(this),t);let e=Un.r,n=Un.g,s=Un.b;return t!==li?`color(${t} ${e.toFixed(3)} ${n.toFixed(3)} ${s.toFixed(3)})`:`rgb(${Math.round(e*255)},${Math.round(n*255)},${Math.round(s*255)})`}offsetHSL(t,e,n){return this.getHSL(Os),this.setHSL(Os.h+t,Os.s+e,Os.l+n)}add(t){return this.r+=t.r,this.g+=t.g,this.b+=t.b,this}addColors(t,e){return this.r=t.r+e.r,this.g=t.g+e.g,this.b=t.b+e.b,this}addScalar(t){return this.r+=t,this.g+=t,this.b+=t,this}sub(t){return this.r=Math.max(0,this.r-t.r),this.g=Math.max(0,this.g-t.g),this.b=Math.max(0,this.b-t.b),this}multiply(t){return this.r*=t.r,this.g*=t.g,this.b*=t.b,this}multiplyScalar(t){return this.r*=t,this.g*=t,this.b*=t,this}lerp(t,e){return this.r+=(t.r-this.r)*e,this.g+=(t.g-this.g)*e,this.b+=(t.b-this.b)*e,this}lerpColors(t,e,n){return this.r=t.r+(e.r-t.r)*n,this.g=t.g+(e.g-t.g)*n,this.b=t.b+(e.b-t.b)*n,this}lerpHSL(t,e){this.getHSL(Os),t.getHSL(Cl);let n=rf(Os.h,Cl.h,e),s=rf(Os.s,Cl.s,e),r=rf(Os.l,Cl.l,e);return this.setHSL(n,s,r),this}setFromVector3(t){return this.r=t.x,this.g=t.y,this.b=t.z,this}applyMatrix3(t){let e=this.r,n=this.g,s=this.b,r=t.elements;return this.r=r[0]*e+r[3]*n+r[6]*s,this.g=r[1]*e+r[4]*n+r[7]*s,this.b=r[2]*e+r[5]*n+r[8]*s,this}equals(t){return t.r===this.r&&t.g===this.g&&t.b===this.b}fromArray(t,e=0){return this.r=t[e],this.g=t[e+1],this.b=t[e+2],this}toArray(t=[],e=0){return t[e]=this.r,t[e+1]=this.g,t[e+2]=this.b,t}fromBufferAttribute(t,e){return this.r=t.getX(e),this.g=t.getY(e),this.b=t.getZ(e),this}toJSON(){return this.getHex()}*[Symbol.iterator](){yield this.r,yield this.g,yield this.b}},Un=new Yt;Yt.NAMES=M0;var sa=class extends hi{constructor(){super(),this.isScene=!0,this.type="Scene",this.background=null,this.environment=null,this.fog=null,this.backgroundBlurriness=0,this.backgroundIntensity=1,this.backgroundRotation=new Hs,this.environmentIntensity=1,this.environmentRotation=new Hs,this.overrideMaterial=null,typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("observe",{detail:this}))}copy(t,e){return super.copy(t,e),this.background=t.background!==null?t.background.clone():null,this.environment=t.environment!==null?t.environment.clone():null,this.fog=t.fog!==null?t.fog.clone():null,this.backgroundBlurriness=t.backgroundBlurriness,this.backgroundIntensity=t.backgroundIntensity,this.backgroundRotation.copy(t.backgroundRotation),this.environmentIntensity=t.environmentIntensity,this.environmentRotation.copy(t.environmentRotation),this.overrideMaterial=t.overrideMaterial!==null?t.overrideMaterial.clone():null,this.matrixAutoUpdate=t.matrixAutoUpdate,this}toJSON(t){let e=super.toJSON(t);return this.fog!==null&&(e.object.fog=this.fog.toJSON()),e.object.backgroundBlurriness=this.backgroundBlurriness,e.object.backgroundIntensity=this.backgroundIntensity,e.object.backgroundRotation=this.backgroundRotation.toArray(),e.object.environmentIntensity=this.environmentIntensity,e.object.environmentRotation=this.environmentRotation.toArray(),e}},Ci=new q,hs=new q,ff=new q,us=new q,eo=new q,no=new q,Tg=new q,df=new q,pf=new q,mf=new q,gf=new qe,xf=new qe,_f=new qe,Vs=class i{constructor(t=new q,e=new q,n=new q){this.a=t,this.b=e,this.c=n}static getNormal(t,e,n,s){s.subVectors(n,e),Ci.subVectors(t,e),s.cross(Ci);let r=s.lengthSq();return r>0?s.multiplyScalar(1/Math.sqrt(r)):s.set(0,0,0)}static getBarycoord(t,e,n,s,r){Ci.subVectors(s,e),hs.subVectors(n,e),ff.subVectors(t,e);let o=Ci.dot(Ci),a=Ci.dot(hs),l=Ci.dot(ff),c=hs.dot(hs),h=hs.dot(ff),f=o*c-a*a;if(f===0)return r.set(0,0,0),null;let u=1/f,d=(c*l-a*h)*u,g=(o*h-a*l)*u;return r.set(1-d-g,g,d)}static containsPoint(t,e,n,s){return this.getBarycoord(t,e,n,s,us)===null?!1:us.x>=0&&us.y>=0&&us.x+us.y<=1}static getInterpolation(t,e,n,s,r,o,a,l){return this.getBarycoord(t,e,n,s,us)===null?(l.x=0,l.y=0,"z"in l&&(l.z=0),"w"in l&&(l.w=0),null):(l.setScalar(0),l.addScaledVector(r,us.x),l.addScaledVector(o,us.y),l.addScaledVector(a,us.z),l)}static getInterpolatedAttribute(t,e,n,s,r,o){return gf.setScalar(0),xf.setScalar(0),_f.setScalar(0),gf.fromBufferAttribute(t,e),xf.fromBufferAttribute(t,n),_f.fromBufferAttribute(t,s),o.setScalar(0),o.addScaledVector(gf,r.x),o.addScaledVector(xf,r.y),o.addScaledVector(_f,r.z),o}static isFrontFacing(t,e,n,s){return Ci.subVectors(n,e),hs.subVectors(t,e),Ci.cross(hs).dot(s)<0}set(t,e,n){return this.a.copy(t),this.b.copy(e),this.c.copy(n),this}setFromPointsAndIndices(t,e,n,s){return this.a.copy(t[e]),this.b.copy(t[n]),this.c.copy(t[s]),this}setFromAttributeAndIndices(t,e,n,s){return this.a.fromBufferAttribute(t,e),this.b.fromBufferAttribute(t,n),this.c.fromBufferAttribute(t,s),this}clone(){return new this.constructor().copy(this)}copy(t){return this.a.copy(t.a),this.b.copy(t.b),this.c.copy(t.c),this}getArea(){return Ci.subVectors(this.c,this.b),hs.subVectors(this.a,this.b),Ci.cross(hs).length()*.5}getMidpoint(t){return t.addVectors(this.a,this.b).add(this.c).multiplyScalar(1/3)}getNormal(t){return i.getNormal(this.a,this.b,this.c,t)}getPlane(t){return t.setFromCoplanarPoints(this.a,this.b,this.c)}getBarycoord(t,e){return i.getBarycoord(t,this.a,this.b,this.c,e)}getInterpolation(t,e,n,s,r){return i.getInterpolation(t,this.a,this.b,this.c,e,n,s,r)}containsPoint(t){return i.containsPoint(t,this.a,this.b,this.c)}isFrontFacing(t){return i.isFrontFacing(this.a,this.b,this.c,t)}intersectsBox(t){return t.intersectsTriangle(this)}closestPointToPoint(t,e){let n=this.a,s=this.b,r=this.c,o,a;eo.subVectors(s,n),no.subVectors(r,n),df.subVectors(t,n);let l=eo.dot(df),c=no.dot(df);if(l<=0&&c<=0)return e.copy(n);pf.subVectors(t,s);let h=eo.dot(pf),f=no.dot(pf);if(h>=0&&f<=h)return e.copy(s);let u=l*f-h*c;if(u<=0&&l>=0&&h<=0&&l-h>0)return o=l/(l-h),e.copy(n).addScaledVector(eo,o);mf.subVectors(t,r);let d=eo.dot(mf),g=no.dot(mf);if(g>=0&&d<=g)return e.copy(r);let M=d*c-l*g;if(M<=0&&c>=0&&g<=0)return a=c/(c-g),e.copy(n).addScaledVector(no,a);let m=h*g-d*f;if(m<=0&&f-h>=0&&d-g>=0)return Tg.subVectors(r,s),a=(f-h)/(f-h+(d-g)),e.copy(s).addScaledVector(Tg,a);let p=1/(m+M+u);return o=M*p,a=u*p,e.copy(n).addScaledVector(eo,o).addScaledVector(no,a)}equals(t){return t.a.equals(this.a)&&t.b.equals(this.b)&&t.c.equals(this.c)}},Ki=class{constructor(t=new q(1/0,1/0,1/0),e=new q(-1/0,-1/0,-1/0)){this.isBox3=!0,this.min=t,this.max=e}set(t,e){return this.min.copy(t),this.max.copy(e),this}setFromArray(t){this.makeEmpty();for(let e=0,n=t.length;e<n;e+=3)this.expandByPoint(Pi.fromArray(t,e));return this}setFromBufferAttribute(t){this.makeEmpty();for(let e=0,n=t.count;e<n;e++)this.expandByPoint(Pi.fromBufferAttribute(t,e));return this}setFromPoints(t){this.makeEmpty();for(let e=0,n=t.length;e<n;e++)this.expandByPoint(t[e]);return this}setFromCenterAndSize(t,e){let n=Pi.copy(e).multiplyScalar(.5);return this.min.copy(t).sub(n),this.max.copy(t).add(n),this}setFromObject(t,e=!1){return this.makeEmpty(),this.expandByObject(t,e)}clone(){return new this.constructor().copy(this)}copy(t){return this.min.copy(t.min),this.max.copy(t.max),this}makeEmpty(){return this.min.x=this.min.y=this.min.z=1/0,this.max.x=this.max.y=this.max.z=-1/0,this}isEmpty(){return this.max.x<this.min.x||this.max.y<this.min.y||this.max.z<this.min.z}getCenter(t){return this.isEmpty()?t.set(0,0,0):t.addVectors(this.min,this.max).multiplyScalar(.5)}getSize(t){return this.isEmpty()?t.set(0,0,0):t.subVectors(this.max,this.min)}expandByPoint(t){return this.min.min(t),this.max.max(t),this}expandByVector(t){return this.min.sub(t),this.max.add(t),this}expandByScalar(t){return this.min.addScalar(-t),this.max.addScalar(t),this}expandByObject(t,e=!1){t.updateWorldMatrix(!1,!1);let n=t.geometry;if(n!==void 0){let r=n.getAttribute("position");if(e===!0&&r!==void 0&&t.isInstancedMesh!==!0&&t.isBatchedMesh!==!0)for(let o=0,a=r.count;o<a;o++)t.isMesh===!0?t.getVertexPosition(o,Pi):Pi.fromBufferAttribute(r,o),Pi.applyMatrix4(t.matrixWorld),this.expandByPoint(Pi);else t.boundingBox!==void 0?(t.boundingBox===null&&t.computeBoundingBox(),Pl.copy(t.boundingBox)):(n.boundingBox===null&&n.computeBoundingBox(),Pl.copy(n.boundingBox)),Pl.applyMatrix4(t.matrixWorld),this.union(Pl)}let s=t.children;for(let r=0,o=s.length;r<o;r++)this.expandByObject(s[r],e);return this}containsPoint(t){return t.x>=this.min.x&&t.x<=this.max.x&&t.y>=this.min.y&&t.y<=this.max.y&&t.z>=this.min.z&&t.z<=this.max.z}containsBox(t){return this.min.x<=t.min.x&&t.max.x<=this.max.x&&this.min.y<=t.min.y&&t.max.y<=this.max.y&&this.min.z<=t.min.z&&t.max.z<=this.max.z}getParameter(t,e){return e.set((t.x-this.min.x)/(this.max.x-this.min.x),(t.y-this.min.y)/(this.max.y-this.min.y),(t.z-this.min.z)/(this.max.z-this.min.z))}intersectsBox(t){return t.max.x>=this.min.x&&t.min.x<=this.max.x&&t.max.y>=this.min.y&&t.min.y<=this.max.y&&t.max.z>=this.min.z&&t.min.z<=this.max.z}intersectsSphere(t){return this.clampPoint(t.center,Pi),Pi.distanceToSquared(t.center)<=t.radius*t.radius}intersectsPlane(t){let e,n;return t.normal.x>0?(e=t.normal.x*this.min.x,n=t.normal.x*this.max.x):(e=t.normal.x*this.max.x,n=t.normal.x*this.min.x),t.normal.y>0?(e+=t.normal.y*this.min.y,n+=t.normal.y*this.max.y):(e+=t.normal.y*this.max.y,n+=t.normal.y*this.min.y),t.normal.z>0?(e+=t.normal.z*this.min.z,n+=t.normal.z*this.max.z):(e+=t.normal.z*this.max.z,n+=t.normal.z*this.min.z),e<=-t.constant&&n>=-t.constant}intersectsTriangle(t){if(this.isEmpty())return!1;this.getCenter($o),Il.subVectors(this.max,$o),io.subVectors(t.a,$o),so.subVectors(t.b,$o),ro.subVectors(t.c,$o),Bs.subVectors(so,io),ks.subVectors(ro,so),cr.subVectors(io,ro);let e=[0,-Bs.z,Bs.y,0,-ks.z,ks.y,0,-cr.z,cr.y,Bs.z,0,-Bs.x,ks.z,0,-ks.x,cr.z,0,-cr.x,-Bs.y,Bs.x,0,-ks.y,ks.x,0,-cr.y,cr.x,0];return!vf(e,io,so,ro,Il)||(e=[1,0,0,0,1,0,0,0,1],!vf(e,io,so,ro,Il))?!1:(Ll.crossVectors(Bs,ks),e=[Ll.x,Ll.y,Ll.z],vf(e,io,so,ro,Il))}clampPoint(t,e){return e.copy(t).clamp(this.min,this.max)}distanceToPoint(t){return this.clampPoint(t,Pi).distanceTo(t)}getBoundingSphere(t){return this.isEmpty()?t.makeEmpty():(this.getCenter(t.center),t.radius=this.getSize(Pi).length()*.5),t}intersect(t){return this.min.max(t.min),this.max.min(t.max),this.isEmpty()&&this.makeEmpty(),this}union(t){return this.min.min(t.min),this.max.max(t.max),this}applyMatrix4(t){return this.isEmpty()?this:(fs[0].set(this.min.x,this.min.y,this.min.z).applyMatrix4(t),fs[1].set(this.min.x,this.min.y,this.max.z).applyMatrix4(t),fs[2].set(this.min.x,this.max.y,this.min.z).applyMatrix4(t),fs[3].set(this.min.x,this.max.y,this.max.z).applyMatrix4(t),fs[4].set(this.max.x,this.min.y,this.min.z).applyMatrix4(t),fs[5].set(this.max.x,this.min.y,this.max.z).applyMatrix4(t),fs[6].set(this.max.x,this.max.y,this.min.z).applyMatrix4(t),fs[7].set(this.max.x,this.max.y,this.max.z).applyMatrix4(t),this.setFromPoints(fs),this)}translate(t){return this.min.add(t),this.max.add(t),this}equals(t){return t.min.equals(this.min)&&t.max.equals(this.max)}toJSON(){return{min:this.min.toArray(),max:this.max.toArray()}}fromJSON(t){return this.min.fromArray(t.min),this.max.fromArray(t.max),this}},fs=[new q,new q,new q,new q,new q,new q,new q,new q],Pi=new q,Pl=new Ki,io=new q,so=new q,ro=new q,Bs=new q,ks=new q,cr=new q,$o=new q,Il=new q,Ll=new q,hr=new q;function vf(i,t,e,n,s){for(let r=0,o=i.length-3;r<=o;r+=3){hr.fromArray(i,r);let a=s.x*Math.abs(hr.x)+s.y*Math.abs(hr.y)+s.z*Math.abs(hr.z),l=t.dot(hr),c=e.dot(hr),h=n.dot(hr);if(Math.max(-Math.max(l,c,h),Math.min(l,c,h))>a)return!1}return!0}var pn=new q,Nl=new Jt,Hb=0,De=class extends Zi{constructor(t,e,n=!1){if(super(),Array.isArray(t))throw new TypeError("THREE.BufferAttribute: array should be a Typed Array.");this.isBufferAttribute=!0,Object.defineProperty(this,"id",{value:Hb++}),this.name="",this.array=t,this.itemSize=e,this.count=t!==void 0?t.length/e:0,this.normalized=n,this.usage=id,this.updateRanges=[],this.gpuType=Ni,this.version=0,this._normalizationScale=t!==void 0?xh(t):void 0}onUploadCallback(){}set needsUpdate(t){t===!0&&this.version++}setUsage(t){return this.usage=t,this}addUpdateRange(t,e){this.updateRanges.push({start:t,count:e})}clearUpdateRanges(){this.updateRanges.length=0}copy(t){return this.name=t.name,this.array=new t.array.constructor(t.array),this.itemSize=t.itemSize,this.count=t.count,this.normalized=t.normalized,this.usage=t.usage,this.gpuType=t.gpuType,this._normalizationScale=t._normalizationScale,this}copyAt(t,e,n){t*=this.itemSize,n*=e.itemSize;for(let s=0,r=this.itemSize;s<r;s++)this.array[t+s]=e.array[n+s];return this}copyArray(t){return this.array.set(t),this}applyMatrix3(t){if(this.itemSize===2)for(let e=0,n=this.count;e<n;e++)Nl.fromBufferAttribute(this,e),Nl.applyMatrix3(t),this.setXY(e,Nl.x,Nl.y);else if(this.itemSize===3)for(let e=0,n=this.count;e<n;e++)pn.fromBufferAttribute(this,e),pn.applyMatrix3(t),this.setXYZ(e,pn.x,pn.y,pn.z);return this}applyMatrix4(t){for(let e=0,n=this.count;e<n;e++)pn.fromBufferAttribute(this,e),pn.applyMatrix4(t),this.setXYZ(e,pn.x,pn.y,pn.z);return this}applyNormalMatrix(t){for(let e=0,n=this.count;e<n;e++)pn.fromBufferAttribute(this,e),pn.applyNormalMatrix(t),this.setXYZ(e,pn.x,pn.y,pn.z);return this}transformDirection(t){for(let e=0,n=this.count;e<n;e++)pn.fromBufferAttribute(this,e),pn.transformDirection(t),this.setXYZ(e,pn.x,pn.y,pn.z);return this}set(t,e=0){return this.array.set(t,e),this}getComponent(t,e){let n=this.array[t*this.itemSize+e];return this.normalized&&(n=this._denormalize(n)),n}setComponent(t,e,n){return this.normalized&&(n=this._normalize(n)),this.array[t*this.itemSize+e]=n,this}getX(t){let e=this.array[t*this.itemSize];return this.normalized&&(e=this._denormalize(e)),e}setX(t,e){return this.normalized&&(e=this._normalize(e)),this.array[t*this.itemSize]=e,this}getY(t){let e=this.array[t*this.itemSize+1];return this.normalized&&(e=this._denormalize(e)),e}setY(t,e){return this.normalized&&(e=this._normalize(e)),this.array[t*this.itemSize+1]=e,this}getZ(t){let e=this.array[t*this.itemSize+2];return this.normalized&&(e=this._denormalize(e)),e}setZ(t,e){return this.normalized&&(e=this._normalize(e)),this.array[t*this.itemSize+2]=e,this}getW(t){let e=this.array[t*this.itemSize+3];return this.normalized&&(e=this._denormalize(e)),e}setW(t,e){return this.normalized&&(e=this._normalize(e)),this.array[t*this.itemSize+3]=e,this}setXY(t,e,n){return t*=this.itemSize,this.normalized&&(e=this._normalize(e),n=this._normalize(n)),this.array[t+0]=e,this.array[t+1]=n,this}setXYZ(t,e,n,s){return t*=this.itemSize,this.normalized&&(e=this._normalize(e),n=this._normalize(n),s=this._normalize(s)),this.array[t+0]=e,this.array[t+1]=n,this.array[t+2]=s,this}setXYZW(t,e,n,s,r){return t*=this.itemSize,this.normalized&&(e=this._normalize(e),n=this._normalize(n),s=this._normalize(s),r=this._normalize(r)),this.array[t+0]=e,this.array[t+1]=n,this.array[t+2]=s,this.array[t+3]=r,this}onUpload(t){return this.onUploadCallback=t,this}clone(){return new this.constructor(this.array,this.itemSize).copy(this)}toJSON(){let t={itemSize:this.itemSize,type:this.array.constructor.name,array:Array.from(this.array),normalized:this.normalized};return t.name=this.name,t.usage=this.usage,t.gpuType=this.gpuType,t}dispose(){this.dispatchEvent({type:"dispose"})}_denormalize(t){let e=this._normalizationScale;return e!==void 0?Math.max(t/e,-1):b0(t,this.array)}_normalize(t){let e=this._normalizationScale;return e!==void 0?Math.round(t*e):S0(t,this.array)}};var ra=class extends De{constructor(t,e,n){super(new Uint16Array(t),e,n)}};var oa=class extends De{constructor(t,e,n){super(new Uint32Array(t),e,n)}};var bi=class extends De{constructor(t,e,n){super(new Float32Array(t),e,n)}},Gb=new Ki,Yo=new q,yf=new q,pr=class{constructor(t=new q,e=-1){this.isSphere=!0,this.center=t,this.radius=e}set(t,e){return this.center.copy(t),this.radius=e,this}setFromPoints(t,e){let n=this.center;e!==void 0?n.copy(e):Gb.setFromPoints(t).getCenter(n);let s=0;for(let r=0,o=t.length;r<o;r++)s=Math.max(s,n.distanceToSquared(t[r]));return this.radius=Math.sqrt(s),this}copy(t){return this.center.copy(t.center),this.radius=t.radius,this}isEmpty(){return this.radius<0}makeEmpty(){return this.center.set(0,0,0),this.radius=-1,this}containsPoint(t){return t.distanceToSquared(this.center)<=this.radius*this.radius}distanceToPoint(t){return t.distanceTo(this.center)-this.radius}intersectsSphere(t){let e=this.radius+t.radius;return t.center.distanceToSquared(this.center)<=e*e}intersectsBox(t){return t.intersectsSphere(this)}intersectsPlane(t){return Math.abs(t.distanceToPoint(this.center))<=this.radius}clampPoint(t,e){let n=this.center.distanceToSquared(t);return e.copy(t),n>this.radius*this.radius&&(e.sub(this.center).normalize(),e.multiplyScalar(this.radius).add(this.center)),e}getBoundingBox(t){return this.isEmpty()?(t.makeEmpty(),t):(t.set(this.center,this.center),t.expandByScalar(this.radius),t)}applyMatrix4(t){return this.center.applyMatrix4(t),this.radius=this.radius*t.getMaxScaleOnAxis(),this}translate(t){return this.center.add(t),this}expandByPoint(t){if(this.isEmpty())return this.center.copy(t),this.radius=0,this;Yo.subVectors(t,this.center);let e=Yo.lengthSq();if(e>this.radius*this.radius){let n=Math.sqrt(e),s=(n-this.radius)*.5;this.center.addScaledVector(Yo,s/n),this.radius+=s}return this}union(t){return t.isEmpty()?this:this.isEmpty()?(this.copy(t),this):(this.center.equals(t.center)===!0?this.radius=Math.max(this.radius,t.radius):(yf.subVectors(t.center,this.center).setLength(t.radius),this.expandByPoint(Yo.copy(t.center).add(yf)),this.expandByPoint(Yo.copy(t.center).sub(yf))),this)}equals(t){return t.center.equals(this.center)&&t.radius===this.radius}clone(){return new this.constructor().copy(this)}toJSON(){return{radius:this.radius,center:this.center.toArray()}}fromJSON(t){return this.radius=t.radius,this.center.fromArray(t.center),this}},Wb=0,vi=new Ke,bf=new hi,oo=new q,ai=new Ki,Zo=new Ki,Rn=new q,Fn=class i extends Zi{constructor(){super(),this.isBufferGeometry=!0,Object.defineProperty(this,"id",{value:Wb++}),this.uuid=Mr(),this.name="",this.type="BufferGeometry",this.index=null,this.indirect=null,this.indirectOffset=0,this.attributes={},this.morphAttributes={},this.morphTargetsRelative=!1,this.groups=[],this.boundingBox=null,this.boundingSphere=null,this.drawRange={start:0,count:1/0},this.userData={},this._transformed=!1}getIndex(){return this.index}setIndex(t){return Array.isArray(t)?this.index=new(Cb(t)?oa:ra)(t,1):this.index=t,this}setIndirect(t,e=0){return this.indirect=t,this.indirectOffset=e,this}getIndirect(){return this.indirect}getAttribute(t){return this.attributes[t]}setAttribute(t,e){return this.attributes[t]=e,this}deleteAttribute(t){return delete this.attributes[t],this}hasAttribute(t){return this.attributes[t]!==void 0}addGroup(t,e,n=0){this.groups.push({start:t,count:e,materialIndex:n})}clearGroups(){this.groups=[]}setDrawRange(t,e){this.drawRange.start=t,this.drawRange.count=e}applyMatrix4(t){let e=this.attributes.position;e!==void 0&&(e.applyMatrix4(t),e.needsUpdate=!0);let n=this.attributes.normal;if(n!==void 0){let r=new ie().getNormalMatrix(t);n.applyNormalMatrix(r),n.needsUpdate=!0}let s=this.attributes.tangent;return s!==void 0&&(s.transformDirection(t),s.needsUpdate=!0),this.boundingBox!==null&&this.computeBoundingBox(),this.boundingSphere!==null&&this.computeBoundingSphere(),this._transformed=!0,this}applyQuaternion(t){return vi.makeRotationFromQuaternion(t),this.applyMatrix4(vi),this}rotateX(t){return vi.makeRotationX(t),this.applyMatrix4(vi),this}rotateY(t){return vi.makeRotationY(t),this.applyMatrix4(vi),this}rotateZ(t){return vi.makeRotationZ(t),this.applyMatrix4(vi),this}translate(t,e,n){return vi.makeTranslation(t,e,n),this.applyMatrix4(vi),this}scale(t,e,n){return vi.makeScale(t,e,n),this.applyMatrix4(vi),this}lookAt(t){return bf.lookAt(t),bf.updateMatrix(),this.applyMatrix4(bf.matrix),this}center(){return this.computeBoundingBox(),this.boundingBox.getCenter(oo).negate(),this.translate(oo.x,oo.y,oo.z),this}setFromPoints(t){let e=this.getAttribute("position");if(e===void 0){let n=[];for(let s=0,r=t.length;s<r;s++){let o=t[s];n.push(o.x,o.y,o.z||0)}this.setAttribute("position",new bi(n,3))}else{let n=Math.min(t.length,e.count);for(let s=0;s<n;s++){let r=t[s];e.setXYZ(s,r.x,r.y,r.z||0)}t.length>e.count&&jt("BufferGeometry: Buffer size too small for points data. Use .dispose() and create a new geometry."),e.needsUpdate=!0}return this}computeBoundingBox(){this.boundingBox===null&&(this.boundingBox=new Ki);let t=this.attributes.position,e=this.morphAttributes.position;if(t&&t.isGLBufferAttribute){ne("BufferGeometry.computeBoundingBox(): GLBufferAttribute requires a manual bounding box.",this),this.boundingBox.set(new q(-1/0,-1/0,-1/0),new q(1/0,1/0,1/0));return}if(t!==void 0){if(this.boundingBox.setFromBufferAttribute(t),e)for(let n=0,s=e.length;n<s;n++){let r=e[n];ai.setFromBufferAttribute(r),this.morphTargetsRelative?(Rn.addVectors(this.boundingBox.min,ai.min),this.boundingBox.expandByPoint(Rn),Rn.addVectors(this.boundingBox.max,ai.max),this.boundingBox.expandByPoint(Rn)):(this.boundingBox.expandByPoint(ai.min),this.boundingBox.expandByPoint(ai.max))}}else this.boundingBox.makeEmpty();(isNaN(this.boundingBox.min.x)||isNaN(this.boundingBox.min.y)||isNaN(this.boundingBox.min.z))&&ne('BufferGeometry.computeBoundingBox(): Computed min/max have NaN values. The "position" attribute is likely to have NaN values.',this)}computeBoundingSphere(){this.boundingSphere===null&&(this.boundingSphere=new pr);let t=this.attributes.position,e=this.morphAttributes.position;if(t&&t.isGLBufferAttribute){ne("BufferGeometry.computeBoundingSphere(): GLBufferAttribute requires a manual bounding sphere.",this),this.boundingSphere.set(new q,1/0);return}if(t){let n=this.boundingSphere.center;if(ai.setFromBufferAttribute(t),e)for(let r=0,o=e.length;r<o;r++){let a=e[r];Zo.setFromBufferAttribute(a),this.morphTargetsRelative?(Rn.addVectors(ai.min,Zo.min),ai.expandByPoint(Rn),Rn.addVectors(ai.max,Zo.max),ai.expandByPoint(Rn)):(ai.expandByPoint(Zo.min),ai.expandByPoint(Zo.max))}ai.getCenter(n);let s=0;for(let r=0,o=t.count;r<o;r++)Rn.fromBufferAttribute(t,r),s=Math.max(s,n.distanceToSquared(Rn));if(e)for(let r=0,o=e.length;r<o;r++){let a=e[r],l=this.morphTargetsRelative;for(let c=0,h=a.count;c<h;c++)Rn.fromBufferAttribute(a,c),l&&(oo.fromBufferAttribute(t,c),Rn.add(oo)),s=Math.max(s,n.distanceToSquared(Rn))}this.boundingSphere.radius=Math.sqrt(s),isNaN(this.boundingSphere.radius)&&ne('BufferGeometry.computeBoundingSphere(): Computed radius is NaN. The "position" attribute is likely to have NaN values.',this)}}computeTangents(){let t=this.index,e=this.attributes;if(t===null||e.position===void 0||e.normal===void 0||e.uv===void 0){ne("BufferGeometry: .computeTangents() failed. Missing required attributes (index, position, normal or uv)");return}let n=e.position,s=e.normal,r=e.uv,o=this.getAttribute("tangent");(o===void 0||o.count!==n.count)&&(o=new De(new Float32Array(4*n.count),4),this.setAttribute("tangent",o));let a=[],l=[],c=new Uint8Array(n.count);for(let V=0;V<n.count;V++)a[V]=new q,l[V]=new q;let h=new q,f=new q,u=new q,d=new Jt,g=new Jt,M=new Jt,m=new q,p=new q;function y(V,D,L){c[V]=c[D]=c[L]=1,h.fromBufferAttribute(n,V),f.fromBufferAttribute(n,D),u.fromBufferAttribute(n,L),d.fromBufferAttribute(r,V),g.fromBufferAttribute(r,D),M.fromBufferAttribute(r,L),f.sub(h),u.sub(h),g.sub(d),M.sub(d);let H=1/(g.x*M.y-M.x*g.y);isFinite(H)&&(m.copy(f).multiplyScalar(M.y).addScaledVector(u,-g.y).multiplyScalar(H),p.copy(u).multiplyScalar(g.x).addScaledVector(f,-M.x).multiplyScalar(H),a[V].add(m),a[D].add(m),a[L].add(m),l[V].add(p),l[D].add(p),l[L].add(p))}let A=this.groups;A.length===0&&(A=[{start:0,count:t.count}]);for(let V=0,D=A.length;V<D;++V){let L=A[V],H=L.start,G=L.count;for(let N=H,z=H+G;N<z;N+=3)y(t.getX(N+0),t.getX(N+1),t.getX(N+2))}let w=new q,P=new q,T=new q,_=new q;function E(V){T.fromBufferAttribute(s,V),_.copy(T);let D=a[V];w.copy(D),w.sub(T.multiplyScalar(T.dot(D))).normalize(),P.crossVectors(_,D);let H=P.dot(l[V])<0?-1:1;o.setXYZW(V,w.x,w.y,w.z,H)}for(let V=0,D=n.count;V<D;++V)c[V]&&E(V);this._transformed=!0}computeVertexNormals(){let t=this.index,e=this.getAttribute("position");if(e!==void 0){let n=this.getAttribute("normal");if(n===void 0||n.count!==e.count)n=new De(new Float32Array(e.count*3),3),this.setAttribute("normal",n);else for(let u=0,d=n.count;u<d;u++)n.setXYZ(u,0,0,0);let s=new q,r=new q,o=new q,a=new q,l=new q,c=new q,h=new q,f=new q;if(t)for(let u=0,d=t.count;u<d;u+=3){let g=t.getX(u+0),M=t.getX(u+1),m=t.getX(u+2);s.fromBufferAttribute(e,g),r.fromBufferAttribute(e,M),o.fromBufferAttribute(e,m),h.subVectors(o,r),f.subVectors(s,r),h.cross(f),a.fromBufferAttribute(n,g),l.fromBufferAttribute(n,M),c.fromBufferAttribute(n,m),a.add(h),l.add(h),c.add(h),n.setXYZ(g,a.x,a.y,a.z),n.setXYZ(M,l.x,l.y,l.z),n.setXYZ(m,c.x,c.y,c.z)}else for(let u=0,d=e.count;u<d;u+=3)s.fromBufferAttribute(e,u+0),r.fromBufferAttribute(e,u+1),o.fromBufferAttribute(e,u+2),h.subVectors(o,r),f.subVectors(s,r),h.cross(f),n.setXYZ(u+0,h.x,h.y,h.z),n.setXYZ(u+1,h.x,h.y,h.z),n.setXYZ(u+2,h.x,h.y,h.z);this.normalizeNormals(),n.needsUpdate=!0}}normalizeNormals(){let t=this.attributes.normal;for(let e=0,n=t.count;e<n;e++)Rn.fromBufferAttribute(t,e),Rn.normalize(),t.setXYZ(e,Rn.x,Rn.y,Rn.z)}toNonIndexed(){function t(a,l){let c=a.array,h=a.itemSize,f=a.normalized,u=new c.constructor(l.length*h),d=0,g=0;for(let M=0,m=l.length;M<m;M++){a.isInterleavedBufferAttribute?d=l[M]*a.data.stride+a.offset:d=l[M]*h;for(let p=0;p<h;p++)u[g++]=c[d++]}return new De(u,h,f)}if(this.index===null)return jt("BufferGeometry.toNonIndexed(): BufferGeometry is already non-indexed."),this;let e=new i,n=this.index.array,s=this.attributes;for(let a in s){let l=s[a],c=t(l,n);e.setAttribute(a,c)}let r=this.morphAttributes;for(let a in r){let l=[],c=r[a];for(let h=0,f=c.length;h<f;h++){let u=c[h],d=t(u,n);l.push(d)}e.morphAttributes[a]=l}e.morphTargetsRelative=this.morphTargetsRelative;let o=this.groups;for(let a=0,l=o.length;a<l;a++){let c=o[a];e.addGroup(c.start,c.count,c.materialIndex)}return e}toJSON(){let t={metadata:{version:4.7,type:"BufferGeometry",generator:"BufferGeometry.toJSON"}};if(t.uuid=this.uuid,t.type=this.parameters!==void 0&&this._transformed===!0?"BufferGeometry":this.type,t.name=this.name,Object.keys(this.userData).length>0&&(t.userData=this.userData),this.parameters!==void 0&&this._transformed!==!0){let l=this.parameters;for(let c in l)l[c]!==void 0&&(t[c]=l[c]);return t}t.data={attributes:{}};let e=this.index;e!==null&&(t.data.index={type:e.array.constructor.name,array:Array.prototype.slice.call(e.array)});let n=this.attributes;for(let l in n){let c=n[l];t.data.attributes[l]=c.toJSON(t.data)}let s={},r=!1;for(let l in this.morphAttributes){let c=this.morphAttributes[l],h=[];for(let f=0,u=c.length;f<u;f++){let d=c[f];h.push(d.toJSON(t.data))}h.length>0&&(s[l]=h,r=!0)}r&&(t.data.morphAttributes=s,t.data.morphTargetsRelative=this.morphTargetsRelative);let o=this.groups;o.length>0&&(t.data.groups=JSON.parse(JSON.stringify(o)));let a=this.boundingSphere;return a!==null&&(t.data.boundingSphere=a.toJSON()),t}clone(){return new this.constructor().copy(this)}copy(t){this.index=null,this.attributes={},this.morphAttributes={},this.groups=[],this.boundingBox=null,this.boundingSphere=null;let e={};this.name=t.name;let n=t.index;n!==null&&this.setIndex(n.clone());let s=t.attributes;for(let c in s){let h=s[c];this.setAttribute(c,h.clone(e))}let r=t.morphAttributes;for(let c in r){let h=[],f=r[c];for(let u=0,d=f.length;u<d;u++)h.push(f[u].clone(e));this.morphAttributes[c]=h}this.morphTargetsRelative=t.morphTargetsRelative;let o=t.groups;for(let c=0,h=o.length;c<h;c++){let f=o[c];this.addGroup(f.start,f.count,f.materialIndex)}let a=t.boundingBox;a!==null&&(this.boundingBox=a.clone());let l=t.boundingSphere;return l!==null&&(this.boundingSphere=l.clone()),this.drawRange.start=t.drawRange.start,this.drawRange.count=t.drawRange.count,this.userData=t.userData,this._transformed=t._transformed,this}dispose(){this.dispatchEvent({type:"dispose"})}},uc=class{constructor(t,e){this.isInterleavedBuffer=!0,this.array=t,this.stride=e,this.count=t!==void 0?t.length/e:0,this.usage=id,this.updateRanges=[],this.version=0,this.uuid=Mr()}onUploadCallback(){}set needsUpdate(t){t===!0&&this.version++}setUsage(t){return this.usage=t,this}addUpdateRange(t,e){this.updateRanges.push({start:t,count:e})}clearUpdateRanges(){this.updateRanges.length=0}copy(t){return this.array=new t.array.constructor(t.array),this.count=t.count,this.stride=t.stride,this.usage=t.usage,this}copyAt(t,e,n){t*=this.stride,n*=e.stride;for(let s=0,r=this.stride;s<r;s++)this.array[t+s]=e.array[n+s];return this}set(t,e=0){return this.array.set(t,e),this}clone(t){t.arrayBuffers===void 0&&(t.arrayBuffers={});let e=Ag(this.array);t.arrayBuffers[e]===void 0&&(t.arrayBuffers[e]=this.array.slice(0).buffer);let n=new this.array.constructor(t.arrayBuffers[e]),s=new this.constructor(n,this.stride);return s.setUsage(this.usage),s}onUpload(t){return this.onUploadCallback=t,this}toJSON(t){t.arrayBuffers===void 0&&(t.arrayBuffers={});let e=Ag(this.array);t.arrayBuffers[e]===void 0&&(t.arrayBuffers[e]=Array.from(new Uint32Array(this.array.slice(0).buffer)));let n={uuid:this.uuid,buffer:e,type:this.array.constructor.name,stride:this.stride};return n.usage=this.usage,n}};function Ag(i){return i.buffer._uuid===void 0&&(i.buffer._uuid=Mr()),i.byteOffset===0&&i.byteLength===i.buffer.byteLength?i.buffer._uuid:i.buffer._uuid+":"+i.byteOffset+":"+i.byteLength}var qn=new q,mr=class i{constructor(t,e,n,s=!1){this.isInterleavedBufferAttribute=!0,this.name="",this.data=t,this.itemSize=e,this.offset=n,this.normalized=s,this._normalizationScale=t!==void 0?xh(t.array):void 0}get count(){return this.data.count}get array(){return this.data.array}set needsUpdate(t){this.data.needsUpdate=t}applyMatrix4(t){for(let e=0,n=this.data.count;e<n;e++)qn.fromBufferAttribute(this,e),qn.applyMatrix4(t),this.setXYZ(e,qn.x,qn.y,qn.z);return this}applyNormalMatrix(t){for(let e=0,n=this.count;e<n;e++)qn.fromBufferAttribute(this,e),qn.applyNormalMatrix(t),this.setXYZ(e,qn.x,qn.y,qn.z);return this}transformDirection(t){for(let e=0,n=this.count;e<n;e++)qn.fromBufferAttribute(this,e),qn.transformDirection(t),this.setXYZ(e,qn.x,qn.y,qn.z);return this}getComponent(t,e){let n=this.array[t*this.data.stride+this.offset+e];return this.normalized&&(n=this._denormalize(n)),n}setComponent(t,e,n){return this.normalized&&(n=this._normalize(n)),this.data.array[t*this.data.stride+this.offset+e]=n,this}setX(t,e){return this.normalized&&(e=this._normalize(e)),this.data.array[t*this.data.stride+this.offset]=e,this}setY(t,e){return this.normalized&&(e=this._normalize(e)),this.data.array[t*this.data.stride+this.offset+1]=e,this}setZ(t,e){return this.normalized&&(e=this._normalize(e)),this.data.array[t*this.data.stride+this.offset+2]=e,this}setW(t,e){return this.normalized&&(e=this._normalize(e)),this.data.array[t*this.data.stride+this.offset+3]=e,this}getX(t){let e=this.data.array[t*this.data.stride+this.offset];return this.normalized&&(e=this._denormalize(e)),e}getY(t){let e=this.data.array[t*this.data.stride+this.offset+1];return this.normalized&&(e=this._denormalize(e)),e}getZ(t){let e=this.data.array[t*this.data.stride+this.offset+2];return this.normalized&&(e=this._denormalize(e)),e}getW(t){let e=this.data.array[t*this.data.stride+this.offset+3];return this.normalized&&(e=this._denormalize(e)),e}setXY(t,e,n){return t=t*this.data.stride+this.offset,this.normalized&&(e=this._normalize(e),n=this._normalize(n)),this.data.array[t+0]=e,this.data.array[t+1]=n,this}setXYZ(t,e,n,s){return t=t*this.data.stride+this.offset,this.normalized&&(e=this._normalize(e),n=this._normalize(n),s=this._normalize(s)),this.data.array[t+0]=e,this.data.array[t+1]=n,this.data.array[t+2]=s,this}setXYZW(t,e,n,s,r){return t=t*this.data.stride+this.offset,this.normalized&&(e=this._normalize(e),n=this._normalize(n),s=this._normalize(s),r=this._normalize(r)),this.data.array[t+0]=e,this.data.array[t+1]=n,this.data.array[t+2]=s,this.data.array[t+3]=r,this}clone(t){if(t===void 0){ea("InterleavedBufferAttribute.clone(): Cloning an interleaved buffer attribute will de-interleave buffer data.");let e=[];for(let n=0;n<this.count;n++){let s=n*this.data.stride+this.offset;for(let r=0;r<this.itemSize;r++)e.push(this.data.array[s+r])}return new De(new this.array.constructor(e),this.itemSize,this.normalized)}else return t.interleavedBuffers===void 0&&(t.interleavedBuffers={}),t.interleavedBuffers[this.data.uuid]===void 0&&(t.interleavedBuffers[this.data.uuid]=this.data.clone(t)),new i(t.interleavedBuffers[this.data.uuid],this.itemSize,this.offset,this.normalized)}toJSON(t){if(t===void 0){ea("InterleavedBufferAttribute.toJSON(): Serializing an interleaved buffer attribute will de-interleave buffer data.");let e=[];for(let n=0;n<this.count;n++){let s=n*this.data.stride+this.offset;for(let r=0;r<this.itemSize;r++)e.push(this.data.array[s+r])}return{itemSize:this.itemSize,type:this.array.constructor.name,array:e,normalized:this.normalized}}else return t.interleavedBuffers===void 0&&(t.interleavedBuffers={}),t.interleavedBuffers[this.data.uuid]===void 0&&(t.interleavedBuffers[this.data.uuid]=this.data.toJSON(t)),{isInterleavedBufferAttribute:!0,itemSize:this.itemSize,data:this.data.uuid,offset:this.offset,normalized:this.normalized}}_denormalize(t){let e=this._normalizationScale;return e!==void 0?Math.max(t/e,-1):b0(t,this.data.array)}_normalize(t){let e=this._normalizationScale;return e!==void 0?Math.round(t*e):S0(t,this.data.array)}},Sf=new q,Xb=new q,qb=new ie,Ii=class{constructor(t=new q(1,0,0),e=0){this.isPlane=!0,this.normal=t,this.constant=e}set(t,e){return this.normal.copy(t),this.constant=e,this}setComponents(t,e,n,s){return this.normal.set(t,e,n),this.constant=s,this}setFromNormalAndCoplanarPoint(t,e){return this.normal.copy(t),this.constant=-e.dot(this.normal),this}setFromCoplanarPoints(t,e,n){let s=Sf.subVectors(n,e).cross(Xb.subVectors(t,e)).normalize();return this.setFromNormalAndCoplanarPoint(s,t),this}copy(t){return this.normal.copy(t.normal),this.constant=t.constant,this}normalize(){let t=1/this.normal.length();return this.normal.multiplyScalar(t),this.constant*=t,this}negate(){return this.constant*=-1,this.normal.negate(),this}distanceToPoint(t){return this.normal.dot(t)+this.constant}distanceToSphere(t){return this.distanceToPoint(t.center)-t.radius}projectPoint(t,e){return e.copy(t).addScaledVector(this.normal,-this.distanceToPoint(t))}intersectLine(t,e,n=!0){let s=t.delta(Sf),r=this.normal.dot(s);if(r===0)return this.distanceToPoint(t.start)===0?e.copy(t.start):null;let o=-(t.start.dot(this.normal)+this.constant)/r;return n===!0&&(o<0||o>1)?null:e.copy(t.start).addScaledVector(s,o)}intersectsLine(t){let e=this.distanceToPoint(t.start),n=this.distanceToPoint(t.end);return e<0&&n>0||n<0&&e>0}intersectsBox(t){return t.intersectsPlane(this)}intersectsSphere(t){return t.intersectsPlane(this)}coplanarPoint(t){return t.copy(this.normal).multiplyScalar(-this.constant)}applyMatrix4(t,e){let n=e||qb.getNormalMatrix(t),s=this.coplanarPoint(Sf).applyMatrix4(t),r=this.normal.applyMatrix3(n).normalize();return this.constant=-s.dot(r),this}translate(t){return this.constant-=t.dot(this.normal),this}equals(t){return t.normal.equals(this.normal)&&t.constant===this.constant}clone(){return new this.constructor().copy(this)}toJSON(){return{normal:this.normal.toArray(),constant:this.constant}}fromJSON(t){return this.normal.fromArray(t.normal),this.constant=t.constant,this}},$b=0,Gs=class extends Zi{constructor(){super(),this.isMaterial=!0,Object.defineProperty(this,"id",{value:$b++}),this.uuid=Mr(),this.name="",this.type="Material",this.blending=yo,this.side=$s,this.vertexColors=!1,this.opacity=1,this.transparent=!1,this.alphaHash=!1,this.blendSrc=Ff,this.blendDst=_a,this.blendEquation=yr,this.blendSrcAlpha=null,this.blendDstAlpha=null,this.blendEquationAlpha=null,this.blendColor=new Yt(0,0,0),this.blendAlpha=0,this.depthFunc=uo,this.depthTest=!0,this.depthWrite=!0,this.stencilWriteMask=255,this.stencilFunc=h0,this.stencilRef=0,this.stencilFuncMask=255,this.stencilFail=Jl,this.stencilZFail=Jl,this.stencilZPass=Jl,this.stencilWrite=!1,this.clippingPlanes=null,this.clipIntersection=!1,this.clipShadows=!1,this.shadowSide=null,this.colorWrite=!0,this.precision=null,this.polygonOffset=!1,this.polygonOffsetFactor=0,this.polygonOffsetUnits=0,this.dithering=!1,this.alphaToCoverage=!1,this.premultipliedAlpha=!1,this.forceSinglePass=!1,this.allowOverride=!0,this.visible=!0,this.toneMapped=!0,this.userData={},this.version=0,this._alphaTest=0}get alphaTest(){return this._alphaTest}set alphaTest(t){this._alphaTest>0!=t>0&&this.version++,this._alphaTest=t}onBeforeRender(){}onBeforeCompile(){}customProgramCacheKey(){return this.onBeforeCompile.toString()}setValues(t){if(t!==void 0)for(let e in t){let n=t[e];if(n===void 0){jt(`Material: parameter '${e}' has value of undefined.`);continue}let s=this[e];if(s===void 0){jt(`Material: '${e}' is not a property of THREE.${this.type}.`);continue}s&&s.isColor?s.set(n):s&&s.isVector2&&n&&n.isVector2||s&&s.isEuler&&n&&n.isEuler||s&&s.isVector3&&n&&n.isVector3?s.copy(n):this[e]=n}}toJSON(t){let e=t===void 0||typeof t=="string";e&&(t={textures:{},images:{}});let n={metadata:{version:4.7,type:"Material",generator:"Material.toJSON"}};n.uuid=this.uuid,n.type=this.type,n.blending=this.blending,n.side=this.side,n.shadowSide=this.shadowSide,n.vertexColors=this.vertexColors,n.opacity=this.opacity,n.transparent=this.transparent,n.blendSrc=this.blendSrc,n.blendDst=this.blendDst,n.blendEquation=this.blendEquation,n.blendSrcAlpha=this.blendSrcAlpha,n.blendDstAlpha=this.blendDstAlpha,n.blendEquationAlpha=this.blendEquationAlpha,n.blendColor=this.blendColor.getHex(),n.blendAlpha=this.blendAlpha,n.depthFunc=this.depthFunc,n.depthTest=this.depthTest,n.depthWrite=this.depthWrite,n.colorWrite=this.colorWrite,n.clipIntersection=this.clipIntersection,n.clipShadows=this.clipShadows,n.stencilWriteMask=this.stencilWriteMask,n.stencilFunc=this.stencilFunc,n.stencilRef=this.stencilRef,n.stencilFuncMask=this.stencilFuncMask,n.stencilFail=this.stencilFail,n.stencilZFail=this.stencilZFail,n.stencilZPass=this.stencilZPass,n.stencilWrite=this.stencilWrite,n.polygonOffset=this.polygonOffset,n.polygonOffsetFactor=this.polygonOffsetFactor,n.polygonOffsetUnits=this.polygonOffsetUnits,n.dithering=this.dithering,n.alphaTest=this.alphaTest,n.alphaHash=this.alphaHash,n.alphaToCoverage=this.alphaToCoverage,n.premultipliedAlpha=this.premultipliedAlpha,n.forceSinglePass=this.forceSinglePass,n.allowOverride=this.allowOverride,n.visible=this.visible,n.toneMapped=this.toneMapped,n.name=this.name,this.color&&this.color.isColor&&(n.color=this.color.getHex()),this.roughness!==void 0&&(n.roughness=this.roughness),this.metalness!==void 0&&(n.metalness=this.metalness),this.sheen!==void 0&&(n.sheen=this.sheen),this.sheenColor&&this.sheenColor.isColor&&(n.sheenColor=this.sheenColor.getHex()),this.sheenRoughness!==void 0&&(n.sheenRoughness=this.sheenRoughness),this.emissive&&this.emissive.isColor&&(n.emissive=this.emissive.getHex()),this.emissiveIntensity!==void 0&&(n.emissiveIntensity=this.emissiveIntensity),this.specular&&this.specular.isColor&&(n.specular=this.specular.getHex()),this.specularIntensity!==void 0&&(n.specularIntensity=this.specularIntensity),this.specularColor&&this.specularColor.isColor&&(n.specularColor=this.specularColor.getHex()),this.shininess!==void 0&&(n.shininess=this.shininess),this.clearcoat!==void 0&&(n.clearcoat=this.clearcoat),this.clearcoatRoughness!==void 0&&(n.clearcoatRoughness=this.clearcoatRoughness),this.diffuseRoughness!==void 0&&(n.diffuseRoughness=this.diffuseRoughness),this.diffuseRoughnessMap&&this.diffuseRoughnessMap.isTexture&&(n.diffuseRoughnessMap=this.diffuseRoughnessMap.toJSON(t).uuid),this.clearcoatMap&&this.clearcoatMap.isTexture&&(n.clearcoatMap=this.clearcoatMap.toJSON(t).uuid),this.clearcoatRoughnessMap&&this.clearcoatRoughnessMap.isTexture&&(n.clearcoatRoughnessMap=this.clearcoatRoughnessMap.toJSON(t).uuid),this.clearcoatNormalMap&&this.clearcoatNormalMap.isTexture&&(n.clearcoatNormalMap=this.clearcoatNormalMap.toJSON(t).uuid,n.clearcoatNormalScale=this.clearcoatNormalScale.toArray()),this.sheenColorMap&&this.sheenColorMap.isTexture&&(n.sheenColorMap=this.sheenColorMap.toJSON(t).uuid),this.sheenRoughnessMap&&this.sheenRoughnessMap.isTexture&&(n.sheenRoughnessMap=this.sheenRoughnessMap.toJSON(t).uuid),this.dispersion!==void 0&&(n.dispersion=this.dispersion),this.retroreflectivity!==void 0&&(n.retroreflectivity=this.retroreflectivity),this.iridescence!==void 0&&(n.iridescence=this.iridescence),this.iridescenceIOR!==void 0&&(n.iridescenceIOR=this.iridescenceIOR),this.iridescenceThicknessMinimum!==void 0&&(n.iridescenceThicknessMinimum=this.iridescenceThicknessMinimum),this.iridescenceThicknessMaximum!==void 0&&(n.iridescenceThicknessMaximum=this.iridescenceThicknessMaximum),this.iridescenceMap&&this.iridescenceMap.isTexture&&(n.iridescenceMap=this.iridescenceMap.toJSON(t).uuid),this.iridescenceThicknessMap&&this.iridescenceThicknessMap.isTexture&&(n.iridescenceThicknessMap=this.iridescenceThicknessMap.toJSON(t).uuid),this.anisotropy!==void 0&&(n.anisotropy=this.anisotropy),this.anisotropyRotation!==void 0&&(n.anisotropyRotation=this.anisotropyRotation),this.anisotropyMap&&this.anisotropyMap.isTexture&&(n.anisotropyMap=this.anisotropyMap.toJSON(t).uuid),this.map&&this.map.isTexture&&(n.map=this.map.toJSON(t).uuid),this.matcap&&this.matcap.isTexture&&(n.matcap=this.matcap.toJSON(t).uuid),this.alphaMap&&this.alphaMap.isTexture&&(n.alphaMap=this.alphaMap.toJSON(t).uuid),this.lightMap&&this.lightMap.isTexture&&(n.lightMap=this.lightMap.toJSON(t).uuid,n.lightMapIntensity=this.lightMapIntensity),this.aoMap&&this.aoMap.isTexture&&(n.aoMap=this.aoMap.toJSON(t).uuid,n.aoMapIntensity=this.aoMapIntensity),this.bumpMap&&this.bumpMap.isTexture&&(n.bumpMap=this.bumpMap.toJSON(t).uuid,n.bumpScale=this.bumpScale),this.normalMap&&this.normalMap.isTexture&&(n.normalMap=this.normalMap.toJSON(t).uuid,n.normalMapType=this.normalMapType,n.normalScale=this.normalScale.toArray()),this.displacementMap&&this.displacementMap.isTexture&&(n.displacementMap=this.displacementMap.toJSON(t).uuid,n.displacementScale=this.displacementScale,n.displacementBias=this.displacementBias),this.roughnessMap&&this.roughnessMap.isTexture&&(n.roughnessMap=this.roughnessMap.toJSON(t).uuid),this.metalnessMap&&this.metalnessMap.isTexture&&(n.metalnessMap=this.metalnessMap.toJSON(t).uuid),this.emissiveMap&&this.emissiveMap.isTexture&&(n.emissiveMap=this.emissiveMap.toJSON(t).uuid),this.specularMap&&this.specularMap.isTexture&&(n.specularMap=this.specularMap.toJSON(t).uuid),this.specularIntensityMap&&this.specularIntensityMap.isTexture&&(n.specularIntensityMap=this.specularIntensityMap.toJSON(t).uuid),this.specularColorMap&&this.specularColorMap.isTexture&&(n.specularColorMap=this.specularColorMap.toJSON(t).uuid),this.envMap&&this.envMap.isTexture&&(n.envMap=this.envMap.toJSON(t).uuid,this.combine!==void 0&&(n.combine=this.combine)),this.envMapRotation!==void 0&&(n.envMapRotation=this.envMapRotation.toArray()),this.envMapIntensity!==void 0&&(n.envMapIntensity=this.envMapIntensity),this.reflectivity!==void 0&&(n.reflectivity=this.reflectivity),this.refractionRatio!==void 0&&(n.refractionRatio=this.refractionRatio),this.gradientMap&&this.gradientMap.isTexture&&(n.gradientMap=this.gradientMap.toJSON(t).uuid),this.transmission!==void 0&&(n.transmission=this.transmission),this.transmissionMap&&this.transmissionMap.isTexture&&(n.transmissionMap=this.transmissionMap.toJSON(t).uuid),this.thickness!==void 0&&(n.thickness=this.thickness),this.thicknessMap&&this.thicknessMap.isTexture&&(n.thicknessMap=this.thicknessMap.toJSON(t).uuid),this.attenuationDistance!==void 0&&(n.attenuationDistance=this.attenuationDistance),this.attenuationColor!==void 0&&(n.attenuationColor=this.attenuationColor.getHex()),this.size!==void 0&&(n.size=this.size),this.sizeAttenuation!==void 0&&(n.sizeAttenuation=this.sizeAttenuation),Array.isArray(this.clippingPlanes)&&this.clippingPlanes.length>0&&(n.clippingPlanes=this.clippingPlanes.map(r=>r.toJSON())),this.rotation!==void 0&&(n.rotation=this.rotation),this.depthPacking!==void 0&&(n.depthPacking=this.depthPacking),this.linewidth!==void 0&&(n.linewidth=this.linewidth),this.linecap!==void 0&&(n.linecap=this.linecap),this.linejoin!==void 0&&(n.linejoin=this.linejoin),this.dashSize!==void 0&&(n.dashSize=this.dashSize),this.gapSize!==void 0&&(n.gapSize=this.gapSize),this.scale!==void 0&&(n.scale=this.scale),this.wireframe!==void 0&&(n.wireframe=this.wireframe),this.wireframeLinewidth!==void 0&&(n.wireframeLinewidth=this.wireframeLinewidth),this.wireframeLinecap!==void 0&&(n.wireframeLinecap=this.wireframeLinecap),this.wireframeLinejoin!==void 0&&(n.wireframeLinejoin=this.wireframeLinejoin),this.flatShading!==void 0&&(n.flatShading=this.flatShading),this.fog!==void 0&&(n.fog=this.fog),Object.keys(this.userData).length>0&&(n.userData=this.userData);function s(r){let o=[];for(let a in r){let l=r[a];delete l.metadata,o.push(l)}return o}if(e){let r=s(t.textures),o=s(t.images);r.length>0&&(n.textures=r),o.length>0&&(n.images=o)}return n}fromJSON(t,e){if(t.uuid!==void 0&&(this.uuid=t.uuid),t.name!==void 0&&(this.name=t.name),t.color!==void 0&&this.color!==void 0&&this.color.setHex(t.color),t.roughness!==void 0&&(this.roughness=t.roughness),t.metalness!==void 0&&(this.metalness=t.metalness),t.sheen!==void 0&&(this.sheen=t.sheen),t.sheenColor!==void 0&&(this.sheenColor=new Yt().setHex(t.sheenColor)),t.sheenRoughness!==void 0&&(this.sheenRoughness=t.sheenRoughness),t.emissive!==void 0&&this.emissive!==void 0&&this.emissive.setHex(t.emissive),t.specular!==void 0&&this.specular!==void 0&&this.specular.setHex(t.specular),t.specularIntensity!==void 0&&(this.specularIntensity=t.specularIntensity),t.specularColor!==void 0&&this.specularColor!==void 0&&this.specularColor.setHex(t.specularColor),t.shininess!==void 0&&(this.shininess=t.shininess),t.clearcoat!==void 0&&(this.clearcoat=t.clearcoat),t.clearcoatRoughness!==void 0&&(this.clearcoatRoughness=t.clearcoatRoughness),t.diffuseRoughness!==void 0&&(this.diffuseRoughness=t.diffuseRoughness),t.dispersion!==void 0&&(this.dispersion=t.dispersion),t.retroreflectivity!==void 0&&(this.retroreflectivity=t.retroreflectivity),t.iridescence!==void 0&&(this.iridescence=t.iridescence),t.iridescenceIOR!==void 0&&(this.iridescenceIOR=t.iridescenceIOR),t.iridescenceThicknessMinimum!==void 0&&(this.iridescenceThicknessMinimum=t.iridescenceThicknessMinimum),t.iridescenceThicknessMaximum!==void 0&&(this.iridescenceThicknessMaximum=t.iridescenceThicknessMaximum),t.iridescenceThicknessRange!==void 0&&(this.iridescenceThicknessMinimum=t.iridescenceThicknessRange[0],this.iridescenceThicknessMaximum=t.iridescenceThicknessRange[1]),t.transmission!==void 0&&(this.transmission=t.transmission),t.thickness!==void 0&&(this.thickness=t.thickness),t.attenuationDistance!==void 0&&(this.attenuationDistance=t.attenuationDistance),t.attenuationColor!==void 0&&this.attenuationColor!==void 0&&this.attenuationColor.setHex(t.attenuationColor),t.anisotropy!==void 0&&(this.anisotropy=t.anisotropy),t.anisotropyRotation!==void 0&&(this.anisotropyRotation=t.anisotropyRotation),t.fog!==void 0&&(this.fog=t.fog),t.flatShading!==void 0&&(this.flatShading=t.flatShading),t.blending!==void 0&&(this.blending=t.blending),t.combine!==void 0&&(this.combine=t.combine),t.side!==void 0&&(this.side=t.side),t.shadowSide!==void 0&&(this.shadowSide=t.shadowSide),t.opacity!==void 0&&(this.opacity=t.opacity),t.transparent!==void 0&&(this.transparent=t.transparent),t.alphaTest!==void 0&&(this.alphaTest=t.alphaTest),t.alphaHash!==void 0&&(this.alphaHash=t.alphaHash),t.depthFunc!==void 0&&(this.depthFunc=t.depthFunc),t.depthTest!==void 0&&(this.depthTest=t.depthTest),t.depthWrite!==void 0&&(this.depthWrite=t.depthWrite),t.colorWrite!==void 0&&(this.colorWrite=t.colorWrite),t.clippingPlanes!==void 0&&(this.clippingPlanes=t.clippingPlanes.map(n=>new Ii().fromJSON(n))),t.clipIntersection!==void 0&&(this.clipIntersection=t.clipIntersection),t.clipShadows!==void 0&&(this.clipShadows=t.clipShadows),t.depthPacking!==void 0&&(this.depthPacking=t.depthPacking),t.blendSrc!==void 0&&(this.blendSrc=t.blendSrc),t.blendDst!==void 0&&(this.blendDst=t.blendDst),t.blendEquation!==void 0&&(this.blendEquation=t.blendEquation),t.blendSrcAlpha!==void 0&&(this.blendSrcAlpha=t.blendSrcAlpha),t.blendDstAlpha!==void 0&&(this.blendDstAlpha=t.blendDstAlpha),t.blendEquationAlpha!==void 0&&(this.blendEquationAlpha=t.blendEquationAlpha),t.blendColor!==void 0&&this.blendColor!==void 0&&this.blendColor.setHex(t.blendColor),t.blendAlpha!==void 0&&(this.blendAlpha=t.blendAlpha),t.stencilWriteMask!==void 0&&(this.stencilWriteMask=t.stencilWriteMask),t.stencilFunc!==void 0&&(this.stencilFunc=t.stencilFunc),t.stencilRef!==void 0&&(this.stencilRef=t.stencilRef),t.stencilFuncMask!==void 0&&(this.stencilFuncMask=t.stencilFuncMask),t.stencilFail!==void 0&&(this.stencilFail=t.stencilFail),t.stencilZFail!==void 0&&(this.stencilZFail=t.stencilZFail),t.stencilZPass!==void 0&&(this.stencilZPass=t.stencilZPass),t.stencilWrite!==void 0&&(this.stencilWrite=t.stencilWrite),t.wireframe!==void 0&&(this.wireframe=t.wireframe),t.wireframeLinewidth!==void 0&&(this.wireframeLinewidth=t.wireframeLinewidth),t.wireframeLinecap!==void 0&&(this.wireframeLinecap=t.wireframeLinecap),t.wireframeLinejoin!==void 0&&(this.wireframeLinejoin=t.wireframeLinejoin),t.rotation!==void 0&&(this.rotation=t.rotation),t.linewidth!==void 0&&(this.linewidth=t.linewidth),t.linecap!==void 0&&(this.linecap=t.linecap),t.linejoin!==void 0&&(this.linejoin=t.linejoin),t.dashSize!==void 0&&(this.dashSize=t.dashSize),t.gapSize!==void 0&&(this.gapSize=t.gapSize),t.scale!==void 0&&(this.scale=t.scale),t.polygonOffset!==void 0&&(this.polygonOffset=t.polygonOffset),t.polygonOffsetFactor!==void 0&&(this.polygonOffsetFactor=t.polygonOffsetFactor),t.polygonOffsetUnits!==void 0&&(this.polygonOffsetUnits=t.polygonOffsetUnits),t.dithering!==void 0&&(this.dithering=t.dithering),t.alphaToCoverage!==void 0&&(this.alphaToCoverage=t.alphaToCoverage),t.premultipliedAlpha!==void 0&&(this.premultipliedAlpha=t.premultipliedAlpha),t.forceSinglePass!==void 0&&(this.forceSinglePass=t.forceSinglePass),t.allowOverride!==void 0&&(this.allowOverride=t.allowOverride),t.visible!==void 0&&(this.visible=t.visible),t.toneMapped!==void 0&&(this.toneMapped=t.toneMapped),t.userData!==void 0&&(this.userData=t.userData),t.vertexColors!==void 0&&(typeof t.vertexColors=="number"?this.vertexColors=t.vertexColors>0:this.vertexColors=t.vertexColors),t.size!==void 0&&(this.size=t.size),t.sizeAttenuation!==void 0&&(this.sizeAttenuation=t.sizeAttenuation),t.map!==void 0&&(this.map=e[t.map]||null),t.matcap!==void 0&&(this.matcap=e[t.matcap]||null),t.alphaMap!==void 0&&(this.alphaMap=e[t.alphaMap]||null),t.bumpMap!==void 0&&(this.bumpMap=e[t.bumpMap]||null),t.bumpScale!==void 0&&(this.bumpScale=t.bumpScale),t.normalMap!==void 0&&(this.normalMap=e[t.normalMap]||null),t.normalMapType!==void 0&&(this.normalMapType=t.normalMapType),t.normalScale!==void 0){let n=t.normalScale;Array.isArray(n)===!1&&(n=[n,n]),this.normalScale=new Jt().fromArray(n)}return t.displacementMap!==void 0&&(this.displacementMap=e[t.displacementMap]||null),t.displacementScale!==void 0&&(this.displacementScale=t.displacementScale),t.displacementBias!==void 0&&(this.displacementBias=t.displacementBias),t.roughnessMap!==void 0&&(this.roughnessMap=e[t.roughnessMap]||null),t.metalnessMap!==void 0&&(this.metalnessMap=e[t.metalnessMap]||null),t.emissiveMap!==void 0&&(this.emissiveMap=e[t.emissiveMap]||null),t.emissiveIntensity!==void 0&&(this.emissiveIntensity=t.emissiveIntensity),t.specularMap!==void 0&&(this.specularMap=e[t.specularMap]||null),t.specularIntensityMap!==void 0&&(this.specularIntensityMap=e[t.specularIntensityMap]||null),t.specularColorMap!==void 0&&(this.specularColorMap=e[t.specularColorMap]||null),t.envMap!==void 0&&(this.envMap=e[t.envMap]||null),t.envMapRotation!==void 0&&this.envMapRotation.fromArray(t.envMapRotation),t.envMapIntensity!==void 0&&(this.envMapIntensity=t.envMapIntensity),t.reflectivity!==void 0&&(this.reflectivity=t.reflectivity),t.refractionRatio!==void 0&&(this.refractionRatio=t.refractionRatio),t.lightMap!==void 0&&(this.lightMap=e[t.lightMap]||null),t.lightMapIntensity!==void 0&&(this.lightMapIntensity=t.lightMapIntensity),t.aoMap!==void 0&&(this.aoMap=e[t.aoMap]||null),t.aoMapIntensity!==void 0&&(this.aoMapIntensity=t.aoMapIntensity),t.gradientMap!==void 0&&(this.gradientMap=e[t.gradientMap]||null),t.clearcoatMap!==void 0&&(this.clearcoatMap=e[t.clearcoatMap]||null),t.clearcoatRoughnessMap!==void 0&&(this.clearcoatRoughnessMap=e[t.clearcoatRoughnessMap]||null),t.clearcoatNormalMap!==void 0&&(this.clearcoatNormalMap=e[t.clearcoatNormalMap]||null),t.clearcoatNormalScale!==void 0&&(this.clearcoatNormalScale=new Jt().fromArray(t.clearcoatNormalScale)),t.diffuseRoughnessMap!==void 0&&(this.diffuseRoughnessMap=e[t.diffuseRoughnessMap]||null),t.iridescenceMap!==void 0&&(this.iridescenceMap=e[t.iridescenceMap]||null),t.iridescenceThicknessMap!==void 0&&(this.iridescenceThicknessMap=e[t.iridescenceThicknessMap]||null),t.transmissionMap!==void 0&&(this.transmissionMap=e[t.transmissionMap]||null),t.thicknessMap!==void 0&&(this.thicknessMap=e[t.thicknessMap]||null),t.anisotropyMap!==void 0&&(this.anisotropyMap=e[t.anisotropyMap]||null),t.sheenColorMap!==void 0&&(this.sheenColorMap=e[t.sheenColorMap]||null),t.sheenRoughnessMap!==void 0&&(this.sheenRoughnessMap=e[t.sheenRoughnessMap]||null),this}clone(){return new this.constructor().copy(this)}copy(t){this.name=t.name,this.blending=t.blending,this.side=t.side,this.vertexColors=t.vertexColors,this.opacity=t.opacity,this.transparent=t.transparent,this.blendSrc=t.blendSrc,this.blendDst=t.blendDst,this.blendEquation=t.blendEquation,this.blendSrcAlpha=t.blendSrcAlpha,this.blendDstAlpha=t.blendDstAlpha,this.blendEquationAlpha=t.blendEquationAlpha,this.blendColor.copy(t.blendColor),this.blendAlpha=t.blendAlpha,this.depthFunc=t.depthFunc,this.depthTest=t.depthTest,this.depthWrite=t.depthWrite,this.stencilWriteMask=t.stencilWriteMask,this.stencilFunc=t.stencilFunc,this.stencilRef=t.stencilRef,this.stencilFuncMask=t.stencilFuncMask,this.stencilFail=t.stencilFail,this.stencilZFail=t.stencilZFail,this.stencilZPass=t.stencilZPass,this.stencilWrite=t.stencilWrite;let e=t.clippingPlanes,n=null;if(e!==null){let s=e.length;n=new Array(s);for(let r=0;r!==s;++r)n[r]=e[r].clone()}return this.clippingPlanes=n,this.clipIntersection=t.clipIntersection,this.clipShadows=t.clipShadows,this.shadowSide=t.shadowSide,this.colorWrite=t.colorWrite,this.precision=t.precision,this.polygonOffset=t.polygonOffset,this.polygonOffsetFactor=t.polygonOffsetFactor,this.polygonOffsetUnits=t.polygonOffsetUnits,this.dithering=t.dithering,this.alphaTest=t.alphaTest,this.alphaHash=t.alphaHash,this.alphaToCoverage=t.alphaToCoverage,this.premultipliedAlpha=t.premultipliedAlpha,this.forceSinglePass=t.forceSinglePass,this.allowOverride=t.allowOverride,this.visible=t.visible,this.toneMapped=t.toneMapped,this.userData=JSON.parse(JSON.stringify(t.userData)),this}dispose(){this.dispatchEvent({type:"dispose"})}set needsUpdate(t){t===!0&&this.version++}};var ds=new q,Mf=new q,Dl=new q,Ul=new q,aa=class{constructor(t=new q,e=new q(0,0,-1)){this.origin=t,this.direction=e}set(t,e){return this.origin.copy(t),this.direction.copy(e),this}copy(t){return this.origin.copy(t.origin),this.direction.copy(t.direction),this}at(t,e){return e.copy(this.origin).addScaledVector(this.direction,t)}lookAt(t){return this.direction.copy(t).sub(this.origin).normalize(),this}recast(t){return this.origin.copy(this.at(t,ds)),this}closestPointToPoint(t,e){e.subVectors(t,this.origin);let n=e.dot(this.direction);return n<0?e.copy(this.origin):e.copy(this.origin).addScaledVector(this.direction,n)}distanceToPoint(t){return Math.sqrt(this.distanceSqToPoint(t))}distanceSqToPoint(t){let e=ds.subVectors(t,this.origin).dot(this.direction);return e<0?this.origin.distanceToSquared(t):(ds.copy(this.origin).addScaledVector(this.direction,e),ds.distanceToSquared(t))}distanceSqToSegment(t,e,n,s){Mf.copy(t).add(e).multiplyScalar(.5),Dl.copy(e).sub(t).normalize(),Ul.copy(this.origin).sub(Mf);let r=t.distanceTo(e)*.5,o=-this.direction.dot(Dl),a=Ul.dot(this.direction),l=-Ul.dot(Dl),c=Ul.lengthSq(),h=Math.abs(1-o*o),f,u,d,g;if(h>0)if(f=o*l-a,u=o*a-l,g=r*h,f>=0)if(u>=-g)if(u<=g){let M=1/h;f*=M,u*=M,d=f*(f+o*u+2*a)+u*(o*f+u+2*l)+c}else u=r,f=Math.max(0,-(o*u+a)),d=-f*f+u*(u+2*l)+c;else u=-r,f=Math.max(0,-(o*u+a)),d=-f*f+u*(u+2*l)+c;else u<=-g?(f=Math.max(0,-(-o*r+a)),u=f>0?-r:Math.min(Math.max(-r,-l),r),d=-f*f+u*(u+2*l)+c):u<=g?(f=0,u=Math.min(Math.max(-r,-l),r),d=u*(u+2*l)+c):(f=Math.max(0,-(o*r+a)),u=f>0?r:Math.min(Math.max(-r,-l),r),d=-f*f+u*(u+2*l)+c);else u=o>0?-r:r,f=Math.max(0,-(o*u+a)),d=-f*f+u*(u+2*l)+c;return n&&n.copy(this.origin).addScaledVector(this.direction,f),s&&s.copy(Mf).addScaledVector(Dl,u),d}intersectSphere(t,e){if(t.radius<0)return null;ds.subVectors(t.center,this.origin);let n=ds.dot(this.direction),s=ds.dot(ds)-n*n,r=t.radius*t.radius;if(s>r)return null;let o=Math.sqrt(r-s),a=n-o,l=n+o;return l<0?null:a<0?this.at(l,e):this.at(a,e)}intersectsSphere(t){return t.radius<0?!1:this.distanceSqToPoint(t.center)<=t.radius*t.radius}distanceToPlane(t){let e=t.normal.dot(this.direction);if(e===0)return t.distanceToPoint(this.origin)===0?0:null;let n=-(this.origin.dot(t.normal)+t.constant)/e;return n>=0?n:null}intersectPlane(t,e){let n=this.distanceToPlane(t);return n===null?null:this.at(n,e)}intersectsPlane(t){let e=t.distanceToPoint(this.origin);return e===0||t.normal.dot(this.direction)*e<0}intersectBox(t,e){let n,s,r,o,a,l,c=1/this.direction.x,h=1/this.direction.y,f=1/this.direction.z,u=this.origin;return c>=0?(n=(t.min.x-u.x)*c,s=(t.max.x-u.x)*c):(n=(t.max.x-u.x)*c,s=(t.min.x-u.x)*c),h>=0?(r=(t.min.y-u.y)*h,o=(t.max.y-u.y)*h):(r=(t.max.y-u.y)*h,o=(t.min.y-u.y)*h),n>o||r>s||((r>n||isNaN(n))&&(n=r),(o<s||isNaN(s))&&(s=o),f>=0?(a=(t.min.z-u.z)*f,l=(t.max.z-u.z)*f):(a=(t.max.z-u.z)*f,l=(t.min.z-u.z)*f),n>l||a>s)||((a>n||n!==n)&&(n=a),(l<s||s!==s)&&(s=l),s<0)?null:this.at(n>=0?n:s,e)}intersectsBox(t){return this.intersectBox(t,ds)!==null}intersectTriangle(t,e,n,s,r){let o=this.origin,a=this.direction,l=a.x,c=a.y,h=a.z,f=t.x-o.x,u=t.y-o.y,d=t.z-o.z,g=e.x-o.x,M=e.y-o.y,m=e.z-o.z,p=n.x-o.x,y=n.y-o.y,A=n.z-o.z,w=Math.abs(l),P=Math.abs(c),T=Math.abs(h),_,E,V,D,L,H,G,N,z,J,k,ct;if(w>=P&&w>=T?(V=l,H=f,z=g,ct=p,l>=0?(_=c,E=h,D=u,L=d,G=M,N=m,J=y,k=A):(_=h,E=c,D=d,L=u,G=m,N=M,J=A,k=y)):P>=T?(V=c,H=u,z=M,ct=y,c>=0?(_=h,E=l,D=d,L=f,G=m,N=g,J=A,k=p):(_=l,E=h,D=f,L=d,G=g,N=m,J=p,k=A)):(V=h,H=d,z=m,ct=A,h>=0?(_=l,E=c,D=f,L=u,G=g,N=M,J=p,k=y):(_=c,E=l,D=u,L=f,G=M,N=g,J=y,k=p)),V===0)return null;let K=_/V,Q=E/V,st=1/V,ft=D-K*H,ut=L-Q*H,tt=G-K*z,mt=N-Q*z,_t=J-K*ct,At=k-Q*ct,St=_t*mt-At*tt,Wt=ft*At-ut*_t,oe=tt*ut-mt*ft;if(s){if(St<0||Wt<0||oe<0)return null}else if((St<0||Wt<0||oe<0)&&(St>0||Wt>0||oe>0))return null;let Vt=St+Wt+oe;if(Vt===0)return null;let de=st*(St*H+Wt*z+oe*ct);return(Vt>0?de<0:de>0)?null:this.at(de/Vt,r)}applyMatrix4(t){return this.origin.applyMatrix4(t),this.direction.transformDirection(t),this}equals(t){return t.origin.equals(this.origin)&&t.direction.equals(this.direction)}clone(){return new this.constructor().copy(this)}},fc=class extends Gs{constructor(t){super(),this.isMeshBasicMaterial=!0,this.type="MeshBasicMaterial",this.color=new Yt(16777215),this.map=null,this.lightMap=null,this.lightMapIntensity=1,this.aoMap=null,this.aoMapIntensity=1,this.specularMap=null,this.alphaMap=null,this.envMap=null,this.envMapRotation=new Hs,this.combine=Of,this.reflectivity=1,this.refractionRatio=.98,this.wireframe=!1,this.wireframeLinewidth=1,this.wireframeLinecap="round",this.wireframeLinejoin="round",this.fog=!0,this.setValues(t)}copy(t){return super.copy(t),this.color.copy(t.color),this.map=t.map,this.lightMap=t.lightMap,this.lightMapIntensity=t.lightMapIntensity,this.aoMap=t.aoMap,this.aoMapIntensity=t.aoMapIntensity,this.specularMap=t.specularMap,this.alphaMap=t.alphaMap,this.envMap=t.envMap,this.envMapRotation.copy(t.envMapRotation),this.combine=t.combine,this.reflectivity=t.reflectivity,this.refractionRatio=t.refractionRatio,this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this.wireframeLinecap=t.wireframeLinecap,this.wireframeLinejoin=t.wireframeLinejoin,this.fog=t.fog,this}},Rg=new Ke,ur=new aa,Fl=new pr,Cg=new q,Ol=new q,Bl=new q,kl=new q,wf=new q,zl=new q,Pg=new q,Vl=new q,Cn=class extends hi{constructor(t=new Fn,e=new fc){super(),this.isMesh=!0,this.type="Mesh",this.geometry=t,this.material=e,this.morphTargetDictionary=void 0,this.morphTargetInfluences=void 0,this.count=1,this.updateMorphTargets()}copy(t,e){return super.copy(t,e),t.morphTargetInfluences!==void 0?this.morphTargetInfluences=t.morphTargetInfluences.slice():this.morphTargetInfluences=void 0,t.morphTargetDictionary!==void 0?this.morphTargetDictionary=Object.assign({},t.morphTargetDictionary):this.morphTargetDictionary=void 0,this.material=Array.isArray(t.material)?t.material.slice():t.material,this.geometry=t.geometry,this}updateMorphTargets(){let e=this.geometry.morphAttributes,n=Object.keys(e);if(n.length>0){let s=e[n[0]];if(s!==void 0){this.morphTargetInfluences=[],this.morphTargetDictionary={};for(let r=0,o=s.length;r<o;r++){let a=s[r].name||String(r);this.morphTargetInfluences.push(0),this.morphTargetDictionary[a]=r}}}}getVertexPosition(t,e){let n=this.geometry,s=n.attributes.position,r=n.morphAttributes.position,o=n.morphTargetsRelative;e.fromBufferAttribute(s,t);let a=this.morphTargetInfluences;if(r&&a){zl.set(0,0,0);for(let l=0,c=r.length;l<c;l++){let h=a[l],f=r[l];h!==0&&(wf.fromBufferAttribute(f,t),o?zl.addScaledVector(wf,h):zl.addScaledVector(wf.sub(e),h))}e.add(zl)}return e}intersectsFrustum(t){return t.intersectsObject(this)}raycast(t,e){let n=this.geometry,s=this.material,r=this.matrixWorld;s!==void 0&&(n.boundingSphere===null&&n.computeBoundingSphere(),Fl.copy(n.boundingSphere),Fl.applyMatrix4(r),ur.copy(t.ray).recast(t.near),!(Fl.containsPoint(ur.origin)===!1&&(ur.intersectSphere(Fl,Cg)===null||ur.origin.distanceToSquared(Cg)>(t.far-t.near)**2))&&(Rg.copy(r).invert(),ur.copy(t.ray).applyMatrix4(Rg),!(n.boundingBox!==null&&ur.intersectsBox(n.boundingBox)===!1)&&this._computeIntersections(t,e,ur)))}_computeIntersections(t,e,n){let s,r=this.geometry,o=this.material,a=r.index,l=r.attributes.position,c=r.attributes.uv,h=r.attributes.uv1,f=r.attributes.normal,u=r.groups,d=r.drawRange;if(a!==null)if(Array.isArray(o))for(let g=0,M=u.length;g<M;g++){let m=u[g],p=o[m.materialIndex],y=Math.max(m.start,d.start),A=Math.min(a.count,Math.min(m.start+m.count,d.start+d.count));for(let w=y,P=A;w<P;w+=3){let T=a.getX(w),_=a.getX(w+1),E=a.getX(w+2);s=Hl(this,p,t,n,c,h,f,T,_,E),s&&(s.faceIndex=Math.floor(w/3),s.face.materialIndex=m.materialIndex,e.push(s))}}else{let g=Math.max(0,d.start),M=Math.min(a.count,d.start+d.count);for(let m=g,p=M;m<p;m+=3){let y=a.getX(m),A=a.getX(m+1),w=a.getX(m+2);s=Hl(this,o,t,n,c,h,f,y,A,w),s&&(s.faceIndex=Math.floor(m/3),e.push(s))}}else if(l!==void 0)if(Array.isArray(o))for(let g=0,M=u.length;g<M;g++){let m=u[g],p=o[m.materialIndex],y=Math.max(m.start,d.start),A=Math.min(l.count,Math.min(m.start+m.count,d.start+d.count));for(let w=y,P=A;w<P;w+=3){let T=w,_=w+1,E=w+2;s=Hl(this,p,t,n,c,h,f,T,_,E),s&&(s.faceIndex=Math.floor(w/3),s.face.materialIndex=m.materialIndex,e.push(s))}}else{let g=Math.max(0,d.start),M=Math.min(l.count,d.start+d.count);for(let m=g,p=M;m<p;m+=3){let y=m,A=m+1,w=m+2;s=Hl(this,o,t,n,c,h,f,y,A,w),s&&(s.faceIndex=Math.floor(m/3),e.push(s))}}}};function Yb(i,t,e,n,s,r,o,a){let l;if(t.side===Kn?l=n.intersectTriangle(o,r,s,!0,a):l=n.intersectTriangle(s,r,o,t.side===$s,a),l===null)return null;Vl.copy(a),Vl.applyMatrix4(i.matrixWorld);let c=e.ray.origin.distanceTo(Vl);return c<e.near||c>e.far?null:{distance:c,point:Vl.clone(),object:i}}function Hl(i,t,e,n,s,r,o,a,l,c){i.getVertexPosition(a,Ol),i.getVertexPosition(l,Bl),i.getVertexPosition(c,kl);let h=Yb(i,t,e,n,Ol,Bl,kl,Pg);if(h){let f=new q;Vs.getBarycoord(Pg,Ol,Bl,kl,f),s&&(h.uv=Vs.getInterpolatedAttribute(s,a,l,c,f,new Jt)),r&&(h.uv1=Vs.getInterpolatedAttribute(r,a,l,c,f,new Jt)),o&&(h.normal=Vs.getInterpolatedAttribute(o,a,l,c,f,new q),h.normal.dot(n.direction)>0&&h.normal.multiplyScalar(-1));let u={a,b:l,c,normal:new q,materialIndex:0};Vs.getNormal(Ol,Bl,kl,u.normal),h.face=u,h.barycoord=f}return h}var go=class extends Jn{constructor(t=null,e=1,n=1,s,r,o,a,l,c=on,h=on,f,u){super(null,o,a,l,c,h,s,r,f,u),this.isDataTexture=!0,this.image={data:t,width:e,height:n},this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1}};var fr=new pr,Zb=new Jt(.5,.5),Gl=new q,gr=class{constructor(t=new Ii,e=new Ii,n=new Ii,s=new Ii,r=new Ii,o=new Ii){this.planes=[t,e,n,s,r,o]}set(t,e,n,s,r,o){let a=this.planes;return a[0].copy(t),a[1].copy(e),a[2].copy(n),a[3].copy(s),a[4].copy(r),a[5].copy(o),this}copy(t){let e=this.planes;for(let n=0;n<6;n++)e[n].copy(t.planes[n]);return this}setFromProjectionMatrix(t,e=yi,n=!1){let s=this.planes,r=t.elements,o=r[0],a=r[1],l=r[2],c=r[3],h=r[4],f=r[5],u=r[6],d=r[7],g=r[8],M=r[9],m=r[10],p=r[11],y=r[12],A=r[13],w=r[14],P=r[15];if(s[0].setComponents(c-o,d-h,p-g,P-y).normalize(),s[1].setComponents(c+o,d+h,p+g,P+y).normalize(),s[2].setComponents(c+a,d+f,p+M,P+A).normalize(),s[3].setComponents(c-a,d-f,p-M,P-A).normalize(),n)s[4].setComponents(l,u,m,w).normalize(),s[5].setComponents(c-l,d-u,p-m,P-w).normalize();else if(s[4].setComponents(c-l,d-u,p-m,P-w).normalize(),e===yi)s[5].setComponents(c+l,d+u,p+m,P+w).normalize();else if(e===Qo)s[5].setComponents(l,u,m,w).normalize();else throw new Error("THREE.Frustum.setFromProjectionMatrix(): Invalid coordinate system: "+e);return this}intersectsObject(t){if(t.boundingSphere!==void 0)t.boundingSphere===null&&t.computeBoundingSphere(),fr.copy(t.boundingSphere).applyMatrix4(t.matrixWorld);else{let e=t.geometry;e.boundingSphere===null&&e.computeBoundingSphere(),fr.copy(e.boundingSphere).applyMatrix4(t.matrixWorld)}return this.intersectsSphere(fr)}intersectsSprite(t){fr.center.set(0,0,0);let e=Zb.distanceTo(t.center);return fr.radius=.7071067811865476+e,fr.applyMatrix4(t.matrixWorld),this.intersectsSphere(fr)}intersectsSphere(t){let e=this.planes,n=t.center,s=-t.radius;for(let r=0;r<6;r++)if(e[r].distanceToPoint(n)<s)return!1;return!0}intersectsBox(t){let e=this.planes;for(let n=0;n<6;n++){let s=e[n];if(Gl.x=s.normal.x>0?t.max.x:t.min.x,Gl.y=s.normal.y>0?t.max.y:t.min.y,Gl.z=s.normal.z>0?t.max.z:t.min.z,s.distanceToPoint(Gl)<0)return!1}return!0}containsPoint(t){let e=this.planes;for(let n=0;n<6;n++)if(e[n].distanceToPoint(t)<0)return!1;return!0}clone(){return new this.constructor().copy(this)}},Ig=new Ke,dc=class i{constructor(){this.coordinateSystem=yi,this._frustums=[],this._count=0}setFromArrayCamera(t){let e=t.cameras,n=this._frustums;for(let s=0;s<e.length;s++){let r=e[s];Ig.multiplyMatrices(r.projectionMatrix,r.matrixWorldInverse),n[s]===void 0&&(n[s]=new gr),n[s].setFromProjectionMatrix(Ig,r.coordinateSystem,r.reversedDepth)}return this._count=e.length,this}getFrustum(t){return this._frustums[t]}intersectsObject(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].intersectsObject(t))return!0;return!1}intersectsSprite(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].intersectsSprite(t))return!0;return!1}intersectsSphere(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].intersectsSphere(t))return!0;return!1}intersectsBox(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].intersectsBox(t))return!0;return!1}containsPoint(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].containsPoint(t))return!0;return!1}copy(t){this.coordinateSystem=t.coordinateSystem;let e=this._frustums,n=t._frustums;for(let s=0;s<t._count;s++)e[s]===void 0&&(e[s]=new gr),e[s].copy(n[s]);return this._count=t._count,this}clone(){return new i().copy(this)}};var pc=class extends Gs{constructor(t){super(),this.isPointsMaterial=!0,this.type="PointsMaterial",this.color=new Yt(16777215),this.map=null,this.alphaMap=null,this.size=1,this.sizeAttenuation=!0,this.fog=!0,this.setValues(t)}copy(t){return super.copy(t),this.color.copy(t.color),this.map=t.map,this.alphaMap=t.alphaMap,this.size=t.size,this.sizeAttenuation=t.sizeAttenuation,this.fog=t.fog,this}},Lg=new Ke,Cf=new aa,Wl=new pr,Xl=new q,la=class extends hi{constructor(t=new Fn,e=new pc){super(),this.isPoints=!0,this.type="Points",this.geometry=t,this.material=e,this.morphTargetDictionary=void 0,this.morphTargetInfluences=void 0,this.updateMorphTargets()}copy(t,e){return super.copy(t,e),t.morphTargetInfluences!==void 0?this.morphTargetInfluences=t.morphTargetInfluences.slice():this.morphTargetInfluences=void 0,t.morphTargetDictionary!==void 0?this.morphTargetDictionary=Object.assign({},t.morphTargetDictionary):this.morphTargetDictionary=void 0,this.material=Array.isArray(t.material)?t.material.slice():t.material,this.geometry=t.geometry,this}intersectsFrustum(t){return t.intersectsObject(this)}raycast(t,e){let n=this.geometry,s=this.matrixWorld,r=t.params.Points.threshold,o=n.drawRange;if(n.boundingSphere===null&&n.computeBoundingSphere(),Wl.copy(n.boundingSphere),Wl.applyMatrix4(s),Wl.radius+=r,t.ray.intersectsSphere(Wl)===!1)return;Lg.copy(s).invert(),Cf.copy(t.ray).applyMatrix4(Lg);let a=r/((this.scale.x+this.scale.y+this.scale.z)/3),l=a*a,c=n.index,f=n.attributes.position;if(c!==null){let u=Math.max(0,o.start),d=Math.min(c.count,o.start+o.count);for(let g=u,M=d;g<M;g++){let m=c.getX(g);Xl.fromBufferAttribute(f,m),Ng(Xl,m,l,s,t,e,this)}}else{let u=Math.max(0,o.start),d=Math.min(f.count,o.start+o.count);for(let g=u,M=d;g<M;g++)Xl.fromBufferAttribute(f,g),Ng(Xl,g,l,s,t,e,this)}}updateMorphTargets(){let e=this.geometry.morphAttributes,n=Object.keys(e);if(n.length>0){let s=e[n[0]];if(s!==void 0){this.morphTargetInfluences=[],this.morphTargetDictionary={};for(let r=0,o=s.length;r<o;r++){let a=s[r].name||String(r);this.morphTargetInfluences.push(0),this.morphTargetDictionary[a]=r}}}}};function Ng(i,t,e,n,s,r,o){let a=Cf.distanceSqToPoint(i);if(a<e){let l=new q;Cf.closestPointToPoint(i,l),l.applyMatrix4(n);let c=s.ray.origin.distanceTo(l);if(c<s.near||c>s.far)return;r.push({distance:c,distanceToRay:Math.sqrt(a),point:l,index:t,face:null,faceIndex:null,barycoord:null,object:o})}}var ca=class extends Jn{constructor(t=[],e=br,n,s,r,o,a,l,c,h){super(t,e,n,s,r,o,a,l,c,h),this.isCubeTexture=!0,this.flipY=!1}get images(){return this.image}set images(t){this.image=t}},ha=class extends Jn{constructor(t,e,n,s,r,o,a,l,c){super(t,e,n,s,r,o,a,l,c),this.isCanvasTexture=!0,this.needsUpdate=!0}};var gs=class extends Jn{constructor(t,e,n=Li,s,r,o,a=on,l=on,c,h=ms,f=1){if(h!==ms&&h!==_s)throw new Error("THREE.DepthTexture: format must be either THREE.DepthFormat or THREE.DepthStencilFormat");let u={width:t,height:e,depth:f};super(u,s,r,o,a,l,h,n,c),this.isDepthTexture=!0,this.flipY=!1,this.generateMipmaps=!1,this.compareFunction=null}copy(t){return super.copy(t),this.source=new po(Object.assign({},t.image)),this.compareFunction=t.compareFunction,this}toJSON(t){let e=super.toJSON(t);return e.compareFunction=this.compareFunction,e}},ua=class extends gs{constructor(t,e=Li,n=br,s,r,o=on,a=on,l,c=ms){let h={width:t,height:t,depth:1},f=[h,h,h,h,h,h];super(t,t,e,n,s,r,o,a,l,c),this.image=f,this.isCubeDepthTexture=!0,this.isCubeTexture=!0}get images(){return this.image}set images(t){this.image=t}},fa=class extends Jn{constructor(t=null){super(),this.sourceTexture=t,this.isExternalTexture=!0}copy(t){return super.copy(t),this.sourceTexture=t.sourceTexture,this}},xo=class i extends Fn{constructor(t=1,e=1,n=1,s=1,r=1,o=1){super(),this.type="BoxGeometry",this.parameters={width:t,height:e,depth:n,widthSegments:s,heightSegments:r,depthSegments:o};let a=this;s=Math.floor(s),r=Math.floor(r),o=Math.floor(o);let l=[],c=[],h=[],f=[],u=0,d=0;g("z","y","x",-1,-1,n,e,t,o,r,0),g("z","y","x",1,-1,n,e,-t,o,r,1),g("x","z","y",1,1,t,n,e,s,o,2),g("x","z","y",1,-1,t,n,-e,s,o,3),g("x","y","z",1,-1,t,e,n,s,r,4),g("x","y","z",-1,-1,t,e,-n,s,r,5),this.setIndex(l),this.setAttribute("position",new bi(c,3)),this.setAttribute("normal",new bi(h,3)),this.setAttribute("uv",new bi(f,2));function g(M,m,p,y,A,w,P,T,_,E,V){let D=w/_,L=P/E,H=w/2,G=P/2,N=T/2,z=_+1,J=E+1,k=0,ct=0,K=new q;for(let Q=0;Q<J;Q++){let st=Q*L-G;for(let ft=0;ft<z;ft++){let ut=ft*D-H;K[M]=ut*y,K[m]=st*A,K[p]=N,c.push(K.x,K.y,K.z),K[M]=0,K[m]=0,K[p]=T>0?1:-1,h.push(K.x,K.y,K.z),f.push(ft/_),f.push(1-Q/E),k+=1}}for(let Q=0;Q<E;Q++)for(let st=0;st<_;st++){let ft=u+st+z*Q,ut=u+st+z*(Q+1),tt=u+(st+1)+z*(Q+1),mt=u+(st+1)+z*Q;l.push(ft,ut,mt),l.push(ut,tt,mt),ct+=6}a.addGroup(d,ct,V),d+=ct,u+=k}}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}static fromJSON(t){return new i(t.width,t.height,t.depth,t.widthSegments,t.heightSegments,t.depthSegments)}};var da=class i extends Fn{constructor(t=1,e=1,n=1,s=1){super(),this.type="PlaneGeometry",this.parameters={width:t,height:e,widthSegments:n,heightSegments:s};let r=t/2,o=e/2,a=Math.floor(n),l=Math.floor(s),c=a+1,h=l+1,f=t/a,u=e/l,d=[],g=[],M=[],m=[];for(let p=0;p<h;p++){let y=p*u-o;for(let A=0;A<c;A++){let w=A*f-r;g.push(w,-y,0),M.push(0,0,1),m.push(A/a),m.push(1-p/l)}}for(let p=0;p<l;p++)for(let y=0;y<a;y++){let A=y+c*p,w=y+c*(p+1),P=y+1+c*(p+1),T=y+1+c*p;d.push(A,w,T),d.push(w,P,T)}this.setIndex(d),this.setAttribute("position",new bi(g,3)),this.setAttribute("normal",new bi(M,3)),this.setAttribute("uv",new bi(m,2))}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}static fromJSON(t){return new i(t.width,t.height,t.widthSegments,t.heightSegments)}};function wr(i){let t={};for(let e in i){t[e]={};for(let n in i[e]){let s=i[e][n];if(Dg(s))s.isRenderTargetTexture?(jt("UniformsUtils: Textures of render targets cannot be cloned via cloneUniforms() or mergeUniforms()."),t[e][n]=null):t[e][n]=s.clone();else if(Array.isArray(s))if(Dg(s[0])){let r=[];for(let o=0,a=s.length;o<a;o++)r[o]=s[o].clone();t[e][n]=r}else t[e][n]=s.slice();else t[e][n]=s}}return t}function Bn(i){let t={};for(let e=0;e<i.length;e++){let n=wr(i[e]);for(let s in n)t[s]=n[s]}return t}function Dg(i){return i&&(i.isColor||i.isMatrix3||i.isMatrix4||i.isVector2||i.isVector3||i.isVector4||i.isTexture||i.isQuaternion)}function Jb(i){let t=[];for(let e=0;e<i.length;e++)t.push(i[e].clone());return t}function rd(i){let t=i.getRenderTarget();return t===null?i.outputColorSpace:t.isXRRenderTarget===!0?t.texture.colorSpace:ge.workingColorSpace}var w0={clone:wr,merge:Bn},Kb=`void main() {
	gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 );
}`,jb=`void main() {
	gl_FragColor = vec4( 1.0, 0.0, 0.0, 1.0 );
}`,mn=class extends Gs{constructor(t){super(),this.isShaderMaterial=!0,this.type="ShaderMaterial",this.defines={},this.uniforms={},this.uniformsGroups=[],this.vertexShader=Kb,this.fragmentShader=jb,this.linewidth=1,this.wireframe=!1,this.wireframeLinewidth=1,this.fog=!1,this.lights=!1,this.clipping=!1,this.forceSinglePass=!0,this.extensions={clipCullDistance:!1,multiDraw:!1},this.defaultAttributeValues={color:[1,1,1],uv:[0,0],uv1:[0,0]},this.index0AttributeName=void 0,this.uniformsNeedUpdate=!1,this.glslVersion=null,t!==void 0&&this.setValues(t)}copy(t){return super.copy(t),this.fragmentShader=t.fragmentShader,this.vertexShader=t.vertexShader,this.uniforms=wr(t.uniforms),this.uniformsGroups=Jb(t.uniformsGroups),this.defines=Object.assign({},t.defines),this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this.fog=t.fog,this.lights=t.lights,this.clipping=t.clipping,this.extensions=Object.assign({},t.extensions),this.glslVersion=t.glslVersion,this.defaultAttributeValues=Object.assign({},t.defaultAttributeValues),this.index0AttributeName=t.index0AttributeName,this.uniformsNeedUpdate=t.uniformsNeedUpdate,this}toJSON(t){let e=super.toJSON(t);e.glslVersion=this.glslVersion,e.uniforms={};for(let s in this.uniforms){let o=this.uniforms[s].value;o&&o.isTexture?e.uniforms[s]={type:"t",value:o.toJSON(t).uuid}:o&&o.isColor?e.uniforms[s]={type:"c",value:o.getHex()}:o&&o.isVector2?e.uniforms[s]={type:"v2",value:o.toArray()}:o&&o.isVector3?e.uniforms[s]={type:"v3",value:o.toArray()}:o&&o.isVector4?e.uniforms[s]={type:"v4",value:o.toArray()}:o&&o.isMatrix3?e.uniforms[s]={type:"m3",value:o.toArray()}:o&&o.isMatrix4?e.uniforms[s]={type:"m4",value:o.toArray()}:e.uniforms[s]={value:o}}Object.keys(this.defines).length>0&&(e.defines=this.defines),e.vertexShader=this.vertexShader,e.fragmentShader=this.fragmentShader,e.lights=this.lights,e.clipping=this.clipping;let n={};for(let s in this.extensions)this.extensions[s]===!0&&(n[s]=!0);return Object.keys(n).length>0&&(e.extensions=n),e}fromJSON(t,e){if(super.fromJSON(t,e),t.uniforms!==void 0)for(let n in t.uniforms){let s=t.uniforms[n];switch(this.uniforms[n]={},s.type){case"t":this.uniforms[n].value=e[s.value]||null;break;case"c":this.uniforms[n].value=new Yt().setHex(s.value);break;case"v2":this.uniforms[n].value=new Jt().fromArray(s.value);break;case"v3":this.uniforms[n].value=new q().fromArray(s.value);break;case"v4":this.uniforms[n].value=new qe().fromArray(s.value);break;case"m3":this.uniforms[n].value=new ie().fromArray(s.value);break;case"m4":this.uniforms[n].value=new Ke().fromArray(s.value);break;default:this.uniforms[n].value=s.value}}if(t.defines!==void 0&&(this.defines=t.defines),t.vertexShader!==void 0&&(this.vertexShader=t.vertexShader),t.fragmentShader!==void 0&&(this.fragmentShader=t.fragmentShader),t.glslVersion!==void 0&&(this.glslVersion=t.glslVersion),t.extensions!==void 0)for(let n in t.extensions)this.extensions[n]=t.extensions[n];return t.lights!==void 0&&(this.lights=t.lights),t.clipping!==void 0&&(this.clipping=t.clipping),this}},mc=class extends mn{constructor(t){super(t),this.isRawShaderMaterial=!0,this.type="RawShaderMaterial"}};var gc=class extends Gs{constructor(t){super(),this.isMeshDepthMaterial=!0,this.type="MeshDepthMaterial",this.depthPacking=l0,this.map=null,this.alphaMap=null,this.displacementMap=null,this.displacementScale=1,this.displacementBias=0,this.wireframe=!1,this.wireframeLinewidth=1,this.setValues(t)}copy(t){return super.copy(t),this.depthPacking=t.depthPacking,this.map=t.map,this.alphaMap=t.alphaMap,this.displacementMap=t.displacementMap,this.displacementScale=t.displacementScale,this.displacementBias=t.displacementBias,this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this}},xc=class extends Gs{constructor(t){super(),this.isMeshDistanceMaterial=!0,this.type="MeshDistanceMaterial",this.map=null,this.alphaMap=null,this.displacementMap=null,this.displacementScale=1,this.displacementBias=0,this.setValues(t)}copy(t){return super.copy(t),this.map=t.map,this.alphaMap=t.alphaMap,this.displacementMap=t.displacementMap,this.displacementScale=t.displacementScale,this.displacementBias=t.displacementBias,this}};function ao(i,t){return!i||i.constructor===t?i:typeof t.BYTES_PER_ELEMENT=="number"?new t(i):Array.prototype.slice.call(i)}function ql(i){return i!==void 0&&i.inTangents!==void 0&&i.outTangents!==void 0}var Ws=class{constructor(t,e,n,s){this.parameterPositions=t,this._cachedIndex=0,this.resultBuffer=s!==void 0?s:new e.constructor(n),this.sampleValues=e,this.valueSize=n,this.settings=null,this.DefaultSettings_={}}evaluate(t){let e=this.parameterPositions,n=this._cachedIndex,s=e[n],r=e[n-1];n:{t:{let o;e:{i:if(!(t<s)){for(let a=n+2;;){if(s===void 0){if(t<r)break i;return n=e.length,this._cachedIndex=n,this.copySampleValue_(n-1)}if(n===a)break;if(r=s,s=e[++n],t<s)break t}o=e.length;break e}if(!(t>=r)){let a=e[1];t<a&&(n=2,r=a);for(let l=n-2;;){if(r===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(n===l)break;if(s=r,r=e[--n-1],t>=r)break t}o=n,n=0;break e}break n}for(;n<o;){let a=n+o>>>1;t<e[a]?o=a:n=a+1}if(s=e[n],r=e[n-1],r===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(s===void 0)return n=e.length,this._cachedIndex=n,this.copySampleValue_(n-1)}this._cachedIndex=n,this.intervalChanged_(n,r,s)}return this.interpolate_(n,r,t,s)}getSettings_(){return this.settings||this.DefaultSettings_}copySampleValue_(t){let e=this.resultBuffer,n=this.sampleValues,s=this.valueSize,r=t*s;for(let o=0;o!==s;++o)e[o]=n[r+o];return e}interpolate_(){throw new Error("THREE.Interpolant: Call to abstract method.")}intervalChanged_(){}},_c=class extends Ws{constructor(t,e,n,s){super(t,e,n,s),this._weightPrev=-0,this._offsetPrev=-0,this._weightNext=-0,this._offsetNext=-0,this.DefaultSettings_={endingStart:Tf,endingEnd:Tf}}intervalChanged_(t,e,n){let s=this.parameterPositions,r=t-2,o=t+1,a=s[r],l=s[o];if(a===void 0)switch(this.getSettings_().endingStart){case Af:r=t,a=2*e-n;break;case Rf:r=s.length-2,a=e+s[r]-s[r+1];break;default:r=t,a=n}if(l===void 0)switch(this.getSettings_().endingEnd){case Af:o=t,l=2*n-e;break;case Rf:o=1,l=n+s[1]-s[0];break;default:o=t-1,l=e}let c=(n-e)*.5,h=this.valueSize;this._weightPrev=c/(e-a),this._weightNext=c/(l-n),this._offsetPrev=r*h,this._offsetNext=o*h}interpolate_(t,e,n,s){let r=this.resultBuffer,o=this.sampleValues,a=this.valueSize,l=t*a,c=l-a,h=this._offsetPrev,f=this._offsetNext,u=this._weightPrev,d=this._weightNext,g=(n-e)/(s-e),M=g*g,m=M*g,p=-u*m+2*u*M-u*g,y=(1+u)*m+(-1.5-2*u)*M+(-.5+u)*g+1,A=(-1-d)*m+(1.5+d)*M+.5*g,w=d*m-d*M;for(let P=0;P!==a;++P)r[P]=p*o[h+P]+y*o[c+P]+A*o[l+P]+w*o[f+P];return r}},vc=class extends Ws{constructor(t,e,n,s){super(t,e,n,s)}interpolate_(t,e,n,s){let r=this.resultBuffer,o=this.sampleValues,a=this.valueSize,l=t*a,c=l-a,h=(n-e)/(s-e),f=1-h;for(let u=0;u!==a;++u)r[u]=o[c+u]*f+o[l+u]*h;return r}},yc=class extends Ws{constructor(t,e,n,s){super(t,e,n,s)}interpolate_(t){return this.copySampleValue_(t-1)}},bc=class extends Ws{interpolate_(t,e,n,s){let r=this.resultBuffer,o=this.sampleValues,a=this.valueSize,l=t*a,c=l-a,h=this.inTangents,f=this.outTangents;if(!h||!f){let g=(n-e)/(s-e),M=1-g;for(let m=0;m!==a;++m)r[m]=o[c+m]*M+o[l+m]*g;return r}let u=a*2,d=t-1;for(let g=0;g!==a;++g){let M=o[c+g],m=o[l+g],p=d*u+g*2,y=f[p],A=f[p+1],w=t*u+g*2,P=h[w],T=h[w+1],_=tS(n,e,y,P,s);r[g]=E0(_,M,A,T,m)}return r}};function E0(i,t,e,n,s){let r=1-i;return r*r*r*t+3*r*r*i*e+3*r*i*i*n+i*i*i*s}function Qb(i,t,e,n,s){let r=1-i;return 3*r*r*(e-t)+6*r*i*(n-e)+3*i*i*(s-n)}function tS(i,t,e,n,s){let r=(i-t)/(s-t);for(let o=0;o<8;o++){let a=E0(r,t,e,n,s)-i;if(Math.abs(a)<1e-10)break;let l=Qb(r,t,e,n,s);if(Math.abs(l)<1e-10)break;r=Math.max(0,Math.min(1,r-a/l))}return r}var ui=class{constructor(t,e,n,s){if(t===void 0)throw new Error("THREE.KeyframeTrack: track name is undefined");if(e===void 0||e.length===0)throw new Error("THREE.KeyframeTrack: no keyframes in track named "+t);this.name=t,this.times=ao(e,this.TimeBufferType),this.values=ao(n,this.ValueBufferType),this.setInterpolation(s||this.DefaultInterpolation)}static toJSON(t){let e=t.constructor,n;if(e.toJSON!==this.toJSON)n=e.toJSON(t);else{n={name:t.name,times:ao(t.times,Array),values:ao(t.values,Array)};let s=t.getInterpolation();s!==t.DefaultInterpolation&&(n.interpolation=s),ql(t.settings)&&(n.settings={inTangents:ao(t.settings.inTangents,Array),outTangents:ao(t.settings.outTangents,Array)})}return n.type=t.ValueTypeName,n}InterpolantFactoryMethodDiscrete(t){return new yc(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodLinear(t){return new vc(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodSmooth(t){return new _c(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodBezier(t){let e=new bc(this.times,this.values,this.getValueSize(),t);return this.settings&&(e.inTangents=this.settings.inTangents,e.outTangents=this.settings.outTangents),e}setInterpolation(t){let e;switch(t){case Ko:e=this.InterpolantFactoryMethodDiscrete;break;case oc:e=this.InterpolantFactoryMethodLinear;break;case Zl:e=this.InterpolantFactoryMethodSmooth;break;case Ef:e=this.InterpolantFactoryMethodBezier;break}if(e===void 0){let n="unsupported interpolation for "+this.ValueTypeName+" keyframe track named "+this.name;if(this.createInterpolant===void 0)if(t!==this.DefaultInterpolation)this.setInterpolation(this.DefaultInterpolation);else throw new Error(n);return jt("KeyframeTrack:",n),this}return this.createInterpolant=e,this}getInterpolation(){switch(this.createInterpolant){case this.InterpolantFactoryMethodDiscrete:return Ko;case this.InterpolantFactoryMethodLinear:return oc;case this.InterpolantFactoryMethodSmooth:return Zl;case this.InterpolantFactoryMethodBezier:return Ef}}getValueSize(){return this.values.length/this.times.length}shift(t){if(t!==0){let e=this.times;for(let n=0,s=e.length;n!==s;++n)e[n]+=t;ql(this.settings)&&(Ug(this.settings.inTangents,t),Ug(this.settings.outTangents,t))}return this}scale(t){if(t!==1){let e=this.times;for(let n=0,s=e.length;n!==s;++n)e[n]*=t;ql(this.settings)&&(Fg(this.settings.inTangents,t),Fg(this.settings.outTangents,t))}return this}trim(t,e){let n=this.times,s=n.length,r=0,o=s-1;for(;r!==s&&n[r]<t;)++r;for(;o!==-1&&n[o]>e;)--o;if(++o,r!==0||o!==s){r>=o&&(o=Math.max(o,1),r=o-1);let a=this.getValueSize();this.times=n.slice(r,o),this.values=this.values.slice(r*a,o*a)}return this}validate(){let t=!0,e=this.getValueSize();e-Math.floor(e)!==0&&(ne("KeyframeTrack: Invalid value size in track.",this),t=!1);let n=this.times,s=this.values,r=n.length;r===0&&(ne("KeyframeTrack: Track is empty.",this),t=!1);let o=null;for(let a=0;a!==r;a++){let l=n[a];if(typeof l=="number"&&isNaN(l)){ne("KeyframeTrack: Time is not a valid number.",this,a,l),t=!1;break}if(o!==null&&o>l){ne("KeyframeTrack: Out of order keys.",this,a,l,o),t=!1;break}o=l}if(s!==void 0&&Pb(s))for(let a=0,l=s.length;a!==l;++a){let c=s[a];if(isNaN(c)){ne("KeyframeTrack: Value is not a valid number.",this,a,c),t=!1;break}}return t}optimize(){let t=this.times.slice(),e=this.values.slice(),n=this.getValueSize(),s=this.getInterpolation()===Zl,r=t.length-1,o=1;for(let a=1;a<r;++a){let l=!1,c=t[a],h=t[a+1];if(c!==h&&(a!==1||c!==t[0]))if(s)l=!0;else{let f=a*n,u=f-n,d=f+n;for(let g=0;g!==n;++g){let M=e[f+g];if(M!==e[u+g]||M!==e[d+g]){l=!0;break}}}if(l){if(a!==o){t[o]=t[a];let f=a*n,u=o*n;for(let d=0;d!==n;++d)e[u+d]=e[f+d]}++o}}if(r>0){t[o]=t[r];for(let a=r*n,l=o*n,c=0;c!==n;++c)e[l+c]=e[a+c];++o}return o!==t.length?(this.times=t.slice(0,o),this.values=e.slice(0,o*n)):(this.times=t,this.values=e),this}clone(){let t=this.times.slice(),e=this.values.slice(),n=this.constructor,s=new n(this.name,t,e);return s.createInterpolant=this.createInterpolant,ql(this.settings)&&(s.settings={inTangents:this.settings.inTangents.slice(),outTangents:this.settings.outTangents.slice()}),s}};function Ug(i,t){for(let e=0,n=i.length;e!==n;e+=2)i[e]+=t}function Fg(i,t){for(let e=0,n=i.length;e!==n;e+=2)i[e]*=t}ui.prototype.ValueTypeName="";ui.prototype.TimeBufferType=Float32Array;ui.prototype.ValueBufferType=Float32Array;ui.prototype.DefaultInterpolation=oc;var Xs=class extends ui{constructor(t,e,n){super(t,e,n)}};Xs.prototype.ValueTypeName="bool";Xs.prototype.ValueBufferType=Array;Xs.prototype.DefaultInterpolation=Ko;Xs.prototype.InterpolantFactoryMethodLinear=void 0;Xs.prototype.InterpolantFactoryMethodSmooth=void 0;var Sc=class extends ui{constructor(t,e,n,s){super(t,e,n,s)}};Sc.prototype.ValueTypeName="color";var Mc=class extends ui{constructor(t,e,n,s){super(t,e,n,s)}};Mc.prototype.ValueTypeName="number";var wc=class extends Ws{constructor(t,e,n,s){super(t,e,n,s)}interpolate_(t,e,n,s){let r=this.resultBuffer,o=this.sampleValues,a=this.valueSize,l=(n-e)/(s-e),c=t*a;for(let h=c+a;c!==h;c+=4)Ji.slerpFlat(r,0,o,c-a,o,c,l);return r}},pa=class extends ui{constructor(t,e,n,s){super(t,e,n,s)}InterpolantFactoryMethodLinear(t){return new wc(this.times,this.values,this.getValueSize(),t)}};pa.prototype.ValueTypeName="quaternion";pa.prototype.InterpolantFactoryMethodSmooth=void 0;var qs=class extends ui{constructor(t,e,n){super(t,e,n)}};qs.prototype.ValueTypeName="string";qs.prototype.ValueBufferType=Array;qs.prototype.DefaultInterpolation=Ko;qs.prototype.InterpolantFactoryMethodLinear=void 0;qs.prototype.InterpolantFactoryMethodSmooth=void 0;var Ec=class extends ui{constructor(t,e,n,s){super(t,e,n,s)}};Ec.prototype.ValueTypeName="vector";var Tc=class{constructor(t,e,n){let s=this,r=!1,o=0,a=0,l,c=[];this.onStart=void 0,this.onLoad=t,this.onProgress=e,this.onError=n,this._abortController=null,this.itemStart=function(h){a++,r===!1&&s.onStart!==void 0&&s.onStart(h,o,a),r=!0},this.itemEnd=function(h){o++,s.onProgress!==void 0&&s.onProgress(h,o,a),o===a&&(r=!1,s.onLoad!==void 0&&s.onLoad())},this.itemError=function(h){s.onError!==void 0&&s.onError(h)},this.resolveURL=function(h){return h=h.normalize("NFC"),l?l(h):h},this.setURLModifier=function(h){return l=h,this},this.addHandler=function(h,f){return c.push(h,f),this},this.removeHandler=function(h){let f=c.indexOf(h);return f!==-1&&c.splice(f,2),this},this.getHandler=function(h){for(let f=0,u=c.length;f<u;f+=2){let d=c[f],g=c[f+1];if(d.global&&(d.lastIndex=0),d.test(h))return g}return null},this.abort=function(){return this.abortController.abort(),this._abortController=null,this}}get abortController(){return this._abortController||(this._abortController=new AbortController),this._abortController}},T0=new Tc,Ac=class{constructor(t){this.manager=t!==void 0?t:T0,this.crossOrigin="anonymous",this.withCredentials=!1,this.path="",this.resourcePath="",this.requestHeader={},this.priority="auto",this.cache="default",typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("observe",{detail:this}))}load(){}loadAsync(t,e){let n=this;return new Promise(function(s,r){n.load(t,s,e,r)})}parse(){}setCrossOrigin(t){return this.crossOrigin=t,this}setWithCredentials(t){return this.withCredentials=t,this}setPath(t){return this.path=t,this}setResourcePath(t){return this.resourcePath=t,this}setRequestHeader(t){return this.requestHeader=t,this}setPriority(t){return this.priority=t,this}setCache(t){return this.cache=t,this}abort(){return this}};Ac.DEFAULT_MATERIAL_NAME="__DEFAULT";var $l=new q,Yl=new Ji,$i=new q,ma=class extends hi{constructor(){super(),this.isCamera=!0,this.type="Camera",this.matrixWorldInverse=new Ke,this.projectionMatrix=new Ke,this.projectionMatrixInverse=new Ke,this.coordinateSystem=yi,this._reversedDepth=!1}get reversedDepth(){return this._reversedDepth}copy(t,e){return super.copy(t,e),this.matrixWorldInverse.copy(t.matrixWorldInverse),this.projectionMatrix.copy(t.projectionMatrix),this.projectionMatrixInverse.copy(t.projectionMatrixInverse),this.coordinateSystem=t.coordinateSystem,this}getWorldDirection(t){return super.getWorldDirection(t).negate()}updateMatrixWorld(t){super.updateMatrixWorld(t),this.matrixWorld.decompose($l,Yl,$i),$i.x===1&&$i.y===1&&$i.z===1?this.matrixWorldInverse.copy(this.matrixWorld).invert():this.matrixWorldInverse.compose($l,Yl,$i.set(1,1,1)).invert()}updateWorldMatrix(t,e,n=!1){super.updateWorldMatrix(t,e,n),this.matrixWorld.decompose($l,Yl,$i),$i.x===1&&$i.y===1&&$i.z===1?this.matrixWorldInverse.copy(this.matrixWorld).invert():this.matrixWorldInverse.compose($l,Yl,$i.set(1,1,1)).invert()}clone(){return new this.constructor().copy(this)}},zs=new q,Og=new Jt,Bg=new Jt,$n=class extends ma{constructor(t=50,e=1,n=.1,s=2e3){super(),this.isPerspectiveCamera=!0,this.type="PerspectiveCamera",this.fov=t,this.zoom=1,this.near=n,this.far=s,this.focus=10,this.aspect=e,this.view=null,this.filmGauge=35,this.filmOffset=0,this.updateProjectionMatrix()}copy(t,e){return super.copy(t,e),this.fov=t.fov,this.zoom=t.zoom,this.near=t.near,this.far=t.far,this.focus=t.focus,this.aspect=t.aspect,this.view=t.view===null?null:Object.assign({},t.view),this.filmGauge=t.filmGauge,this.filmOffset=t.filmOffset,this}setFocalLength(t){let e=.5*this.getFilmHeight()/t;this.fov=ac*2*Math.atan(e),this.updateProjectionMatrix()}getFocalLength(){let t=Math.tan(sf*.5*this.fov);return .5*this.getFilmHeight()/t}getEffectiveFOV(){return ac*2*Math.atan(Math.tan(sf*.5*this.fov)/this.zoom)}getFilmWidth(){return this.filmGauge*Math.min(this.aspect,1)}getFilmHeight(){return this.filmGauge/Math.max(this.aspect,1)}getViewBounds(t,e,n){zs.set(-1,-1,.5).applyMatrix4(this.projectionMatrixInverse),e.set(zs.x,zs.y).multiplyScalar(-t/zs.z),zs.set(1,1,.5).applyMatrix4(this.projectionMatrixInverse),n.set(zs.x,zs.y).multiplyScalar(-t/zs.z)}getViewSize(t,e){return this.getViewBounds(t,Og,Bg),e.subVectors(Bg,Og)}setViewOffset(t,e,n,s,r,o){this.aspect=t/e,this.view===null&&(this.view={enabled:!0,fullWidth:1,fullHeight:1,offsetX:0,offsetY:0,width:1,height:1}),this.view.enabled=!0,this.view.fullWidth=t,this.view.fullHeight=e,this.view.offsetX=n,this.view.offsetY=s,this.view.width=r,this.view.height=o,this.updateProjectionMatrix()}clearViewOffset(){this.view!==null&&(this.view.enabled=!1),this.updateProjectionMatrix()}updateProjectionMatrix(){let t=this.near,e=t*Math.tan(sf*.5*this.fov)/this.zoom,n=2*e,s=this.aspect*n,r=-.5*s,o=this.view;if(this.view!==null&&this.view.enabled){let l=o.fullWidth,c=o.fullHeight;r+=o.offsetX*s/l,e-=o.offsetY*n/c,s*=o.width/l,n*=o.height/c}let a=this.filmOffset;a!==0&&(r+=t*a/this.getFilmWidth()),this.projectionMatrix.makePerspective(r,r+s,e,e-n,t,this.far,this.coordinateSystem,this.reversedDepth),this.projectionMatrixInverse.copy(this.projectionMatrix).invert()}toJSON(t){let e=super.toJSON(t);return e.object.fov=this.fov,e.object.zoom=this.zoom,e.object.near=this.near,e.object.far=this.far,e.object.focus=this.focus,e.object.aspect=this.aspect,this.view!==null&&(e.object.view=Object.assign({},this.view)),e.object.filmGauge=this.filmGauge,e.object.filmOffset=this.filmOffset,e}};var Rc=class extends ma{constructor(t=-1,e=1,n=1,s=-1,r=.1,o=2e3){super(),this.isOrthographicCamera=!0,this.type="OrthographicCamera",this.zoom=1,this.view=null,this.left=t,this.right=e,this.top=n,this.bottom=s,this.near=r,this.far=o,this.updateProjectionMatrix()}copy(t,e){return super.copy(t,e),this.left=t.left,this.right=t.right,this.top=t.top,this.bottom=t.bottom,this.near=t.near,this.far=t.far,this.zoom=t.zoom,this.view=t.view===null?null:Object.assign({},t.view),this}setViewOffset(t,e,n,s,r,o){this.view===null&&(this.view={enabled:!0,fullWidth:1,fullHeight:1,offsetX:0,offsetY:0,width:1,height:1}),this.view.enabled=!0,this.view.fullWidth=t,this.view.fullHeight=e,this.view.offsetX=n,this.view.offsetY=s,this.view.width=r,this.view.height=o,this.updateProjectionMatrix()}clearViewOffset(){this.view!==null&&(this.view.enabled=!1),this.updateProjectionMatrix()}updateProjectionMatrix(){let t=(this.right-this.left)/(2*this.zoom),e=(this.top-this.bottom)/(2*this.zoom),n=(this.right+this.left)/2,s=(this.top+this.bottom)/2,r=n-t,o=n+t,a=s+e,l=s-e;if(this.view!==null&&this.view.enabled){let c=(this.right-this.left)/this.view.fullWidth/this.zoom,h=(this.top-this.bottom)/this.view.fullHeight/this.zoom;r+=c*this.view.offsetX,o=r+c*this.view.width,a-=h*this.view.offsetY,l=a-h*this.view.height}this.projectionMatrix.makeOrthographic(r,o,a,l,this.near,this.far,this.coordinateSystem,this.reversedDepth),this.projectionMatrixInverse.copy(this.projectionMatrix).invert()}toJSON(t){let e=super.toJSON(t);return e.object.zoom=this.zoom,e.object.left=this.left,e.object.right=this.right,e.object.top=this.top,e.object.bottom=this.bottom,e.object.near=this.near,e.object.far=this.far,this.view!==null&&(e.object.view=Object.assign({},this.view)),e}};var xr=class extends Fn{constructor(){super(),this.isInstancedBufferGeometry=!0,this.type="InstancedBufferGeometry",this.instanceCount=1/0}copy(t){return super.copy(t),this.instanceCount=t.instanceCount,this}toJSON(){let t=super.toJSON();return t.instanceCount=this.instanceCount,t.isInstancedBufferGeometry=!0,t}};var lo=-90,co=1,_o=class extends hi{constructor(t,e,n){super(),this.type="CubeCamera",this.renderTarget=n,this.coordinateSystem=null,this.activeMipmapLevel=0;let s=new $n(lo,co,t,e);s.layers=this.layers,this.add(s);let r=new $n(lo,co,t,e);r.layers=this.layers,this.add(r);let o=new $n(lo,co,t,e);o.layers=this.layers,this.add(o);let a=new $n(lo,co,t,e);a.layers=this.layers,this.add(a);let l=new $n(lo,co,t,e);l.layers=this.layers,this.add(l);let c=new $n(lo,co,t,e);c.layers=this.layers,this.add(c)}updateCoordinateSystem(){let t=this.coordinateSystem,e=this.children.concat(),[n,s,r,o,a,l]=e;for(let c of e)this.remove(c);if(t===yi)n.up.set(0,1,0),n.lookAt(1,0,0),s.up.set(0,1,0),s.lookAt(-1,0,0),r.up.set(0,0,-1),r.lookAt(0,1,0),o.up.set(0,0,1),o.lookAt(0,-1,0),a.up.set(0,1,0),a.lookAt(0,0,1),l.up.set(0,1,0),l.lookAt(0,0,-1);else if(t===Qo)n.up.set(0,-1,0),n.lookAt(-1,0,0),s.up.set(0,-1,0),s.lookAt(1,0,0),r.up.set(0,0,1),r.lookAt(0,1,0),o.up.set(0,0,-1),o.lookAt(0,-1,0),a.up.set(0,-1,0),a.lookAt(0,0,1),l.up.set(0,-1,0),l.lookAt(0,0,-1);else throw new Error("THREE.CubeCamera.updateCoordinateSystem(): Invalid coordinate system: "+t);for(let c of e)this.add(c),c.updateMatrixWorld()}update(t,e){this.parent===null&&this.updateMatrixWorld();let{renderTarget:n,activeMipmapLevel:s}=this;this.coordinateSystem!==t.coordinateSystem&&(this.coordinateSystem=t.coordinateSystem,this.updateCoordinateSystem());let[r,o,a,l,c,h]=this.children,f=t.getRenderTarget(),u=t.getActiveCubeFace(),d=t.getActiveMipmapLevel(),g=t.xr.enabled;t.xr.enabled=!1;let M=n.texture.mipmapsAutoUpdate;n.texture.mipmapsAutoUpdate=!1;let m=!1;t.isWebGLRenderer===!0?m=t.state.buffers.depth.getReversed():m=t.reversedDepthBuffer,t.setRenderTarget(n,0,s),m&&t.autoClear===!1&&t.clearDepth(),t.render(e,r),t.setRenderTarget(n,1,s),m&&t.autoClear===!1&&t.clearDepth(),t.render(e,o),t.setRenderTarget(n,2,s),m&&t.autoClear===!1&&t.clearDepth(),t.render(e,a),t.setRenderTarget(n,3,s),m&&t.autoClear===!1&&t.clearDepth(),t.render(e,l),t.setRenderTarget(n,4,s),m&&t.autoClear===!1&&t.clearDepth(),t.render(e,c),n.texture.mipmapsAutoUpdate=M,t.setRenderTarget(n,5,s),m&&t.autoClear===!1&&t.clearDepth(),t.render(e,h),t.setRenderTarget(f,u,d),t.xr.enabled=g,n.texture.needsPMREMUpdate=!0}},Cc=class extends $n{constructor(t=[]){super(),this.isArrayCamera=!0,this.isMultiViewCamera=!1,this.cameras=t,this.perCameraFrustumCulled=!1}};var od="\\[\\]\\.:\\/",eS=new RegExp("["+od+"]","g"),ad="[^"+od+"]",nS="[^"+od.replace("\\.","")+"]",iS=/((?:WC+[\/:])*)/.source.replace("WC",ad),sS=/(WCOD+)?/.source.replace("WCOD",nS),rS=/(?:\.(WC+)(?:\[(.+)\])?)?/.source.replace("WC",ad),oS=/\.(WC+)(?:\[(.+)\])?/.source.replace("WC",ad),aS=new RegExp("^"+iS+sS+rS+oS+"$"),lS=["material","materials","bones","map"],Pf=class{constructor(t,e,n){let s=n||Xe.parseTrackName(e);this._targetGroup=t,this._bindings=t.subscribe_(e,s)}getValue(t,e){this.bind();let n=this._targetGroup.nCachedObjects_,s=this._bindings[n];s!==void 0&&s.getValue(t,e)}setValue(t,e){let n=this._bindings;for(let s=this._targetGroup.nCachedObjects_,r=n.length;s!==r;++s)n[s].setValue(t,e)}bind(){let t=this._bindings;for(let e=this._targetGroup.nCachedObjects_,n=t.length;e!==n;++e)t[e].bind()}unbind(){let t=this._bindings;for(let e=this._targetGroup.nCachedObjects_,n=t.length;e!==n;++e)t[e].unbind()}},Xe=class i{constructor(t,e,n){this.path=e,this.parsedPath=n||i.parseTrackName(e),this.node=i.findNode(t,this.parsedPath.nodeName),this.rootNode=t,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}static create(t,e,n){return t&&t.isAnimationObjectGroup?new i.Composite(t,e,n):new i(t,e,n)}static sanitizeNodeName(t){return t.replace(/\s/g,"_").replace(eS,"")}static parseTrackName(t){let e=aS.exec(t);if(e===null)throw new Error("THREE.PropertyBinding: Cannot parse trackName: "+t);let n={nodeName:e[2],objectName:e[3],objectIndex:e[4],propertyName:e[5],propertyIndex:e[6]},s=n.nodeName&&n.nodeName.lastIndexOf(".");if(s!==void 0&&s!==-1){let r=n.nodeName.substring(s+1);lS.indexOf(r)!==-1&&(n.nodeName=n.nodeName.substring(0,s),n.objectName=r)}if(n.propertyName===null||n.propertyName.length===0)throw new Error("THREE.PropertyBinding: can not parse propertyName from trackName: "+t);return n}static findNode(t,e){if(e===void 0||e===""||e==="."||e===-1||e===t.name||e===t.uuid)return t;if(t.skeleton){let n=t.skeleton.getBoneByName(e);if(n!==void 0)return n}if(t.children){let n=function(r){for(let o=0;o<r.length;o++){let a=r[o];if(a.name===e||a.uuid===e)return a;let l=n(a.children);if(l)return l}return null},s=n(t.children);if(s)return s}return null}_getValue_unavailable(){}_setValue_unavailable(){}_getValue_direct(t,e){t[e]=this.targetObject[this.propertyName]}_getValue_array(t,e){let n=this.resolvedProperty;for(let s=0,r=n.length;s!==r;++s)t[e++]=n[s]}_getValue_arrayElement(t,e){t[e]=this.resolvedProperty[this.propertyIndex]}_getValue_toArray(t,e){this.resolvedProperty.toArray(t,e)}_setValue_direct(t,e){this.targetObject[this.propertyName]=t[e]}_setValue_direct_setNeedsUpdate(t,e){this.targetObject[this.propertyName]=t[e],this.targetObject.needsUpdate=!0}_setValue_direct_setMatrixWorldNeedsUpdate(t,e){this.targetObject[this.propertyName]=t[e],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_array(t,e){let n=this.resolvedProperty;for(let s=0,r=n.length;s!==r;++s)n[s]=t[e++]}_setValue_array_setNeedsUpdate(t,e){let n=this.resolvedProperty;for(let s=0,r=n.length;s!==r;++s)n[s]=t[e++];this.targetObject.needsUpdate=!0}_setValue_array_setMatrixWorldNeedsUpdate(t,e){let n=this.resolvedProperty;for(let s=0,r=n.length;s!==r;++s)n[s]=t[e++];this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_arrayElement(t,e){this.resolvedProperty[this.propertyIndex]=t[e]}_setValue_arrayElement_setNeedsUpdate(t,e){this.resolvedProperty[this.propertyIndex]=t[e],this.targetObject.needsUpdate=!0}_setValue_arrayElement_setMatrixWorldNeedsUpdate(t,e){this.resolvedProperty[this.propertyIndex]=t[e],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_fromArray(t,e){this.resolvedProperty.fromArray(t,e)}_setValue_fromArray_setNeedsUpdate(t,e){this.resolvedProperty.fromArray(t,e),this.targetObject.needsUpdate=!0}_setValue_fromArray_setMatrixWorldNeedsUpdate(t,e){this.resolvedProperty.fromArray(t,e),this.targetObject.matrixWorldNeedsUpdate=!0}_getValue_unbound(t,e){this.bind(),this.getValue(t,e)}_setValue_unbound(t,e){this.bind(),this.setValue(t,e)}bind(){let t=this.node,e=this.parsedPath,n=e.objectName,s=e.propertyName,r=e.propertyIndex;if(t||(t=i.findNode(this.rootNode,e.nodeName),this.node=t),this.getValue=this._getValue_unavailable,this.setValue=this._setValue_unavailable,!t){jt("PropertyBinding: No target node found for track: "+this.path+".");return}if(n){let c=e.objectIndex;switch(n){case"materials":if(!t.material){ne("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.materials){ne("PropertyBinding: Can not bind to material.materials as node.material does not have a materials array.",this);return}t=t.material.materials;break;case"bones":if(!t.skeleton){ne("PropertyBinding: Can not bind to bones as node does not have a skeleton.",this);return}t=t.skeleton.bones;for(let h=0;h<t.length;h++)if(t[h].name===c){c=h;break}break;case"map":if("map"in t){t=t.map;break}if(!t.material){ne("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.map){ne("PropertyBinding: Can not bind to material.map as node.material does not have a map.",this);return}t=t.material.map;break;default:if(t[n]===void 0){ne("PropertyBinding: Can not bind to objectName of node undefined.",this);return}t=t[n]}if(c!==void 0){if(t[c]===void 0){ne("PropertyBinding: Trying to bind to objectIndex of objectName, but is undefined.",this,t);return}t=t[c]}}let o=t[s];if(o===void 0){let c=e.nodeName;ne("PropertyBinding: Trying to update property for track: "+c+"."+s+" but it wasn't found.",t);return}let a=this.Versioning.None;this.targetObject=t,t.isMaterial===!0?a=this.Versioning.NeedsUpdate:t.isObject3D===!0&&(a=this.Versioning.MatrixWorldNeedsUpdate);let l=this.BindingType.Direct;if(r!==void 0){if(s==="morphTargetInfluences"){if(!t.geometry){ne("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.",this);return}if(!t.geometry.morphAttributes){ne("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.morphAttributes.",this);return}t.morphTargetDictionary[r]!==void 0&&(r=t.morphTargetDictionary[r])}l=this.BindingType.ArrayElement,this.resolvedProperty=o,this.propertyIndex=r}else o.fromArray!==void 0&&o.toArray!==void 0?(l=this.BindingType.HasFromToArray,this.resolvedProperty=o):Array.isArray(o)?(l=this.BindingType.EntireArray,this.resolvedProperty=o):this.propertyName=s;this.getValue=this.GetterByBindingType[l],this.setValue=this.SetterByBindingTypeAndVersioning[l][a]}unbind(){this.node=null,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}};Xe.Composite=Pf;Xe.prototype.BindingType={Direct:0,EntireArray:1,ArrayElement:2,HasFromToArray:3};Xe.prototype.Versioning={None:0,NeedsUpdate:1,MatrixWorldNeedsUpdate:2};Xe.prototype.GetterByBindingType=[Xe.prototype._getValue_direct,Xe.prototype._getValue_array,Xe.prototype._getValue_arrayElement,Xe.prototype._getValue_toArray];Xe.prototype.SetterByBindingTypeAndVersioning=[[Xe.prototype._setValue_direct,Xe.prototype._setValue_direct_setNeedsUpdate,Xe.prototype._setValue_direct_setMatrixWorldNeedsUpdate],[Xe.prototype._setValue_array,Xe.prototype._setValue_array_setNeedsUpdate,Xe.prototype._setValue_array_setMatrixWorldNeedsUpdate],[Xe.prototype._setValue_arrayElement,Xe.prototype._setValue_arrayElement_setNeedsUpdate,Xe.prototype._setValue_arrayElement_setMatrixWorldNeedsUpdate],[Xe.prototype._setValue_fromArray,Xe.prototype._setValue_fromArray_setNeedsUpdate,Xe.prototype._setValue_fromArray_setMatrixWorldNeedsUpdate]];var _2=new Float32Array(1);var _r=class extends uc{constructor(t,e,n=1){super(t,e),this.isInstancedInterleavedBuffer=!0,this.meshPerAttribute=n}copy(t){return super.copy(t),this.meshPerAttribute=t.meshPerAttribute,this}clone(t){let e=super.clone(t);return e.meshPerAttribute=this.meshPerAttribute,e}toJSON(t){let e=super.toJSON(t);return e.isInstancedInterleavedBuffer=!0,e.meshPerAttribute=this.meshPerAttribute,e}};var If=class{static{this.prototype.isMatrix2=!0}constructor(t,e,n,s){this.elements=[1,0,0,1],t!==void 0&&this.set(t,e,n,s)}identity(){return this.set(1,0,0,1),this}fromArray(t,e=0){for(let n=0;n<4;n++)this.elements[n]=t[n+e];return this}set(t,e,n,s){let r=this.elements;return r[0]=t,r[2]=e,r[1]=n,r[3]=s,this}},kg=new Jt,ga=class{constructor(t=new Jt(1/0,1/0),e=new Jt(-1/0,-1/0)){this.isBox2=!0,this.min=t,this.max=e}set(t,e){return this.min.copy(t),this.max.copy(e),this}setFromPoints(t){this.makeEmpty();for(let e=0,n=t.length;e<n;e++)this.expandByPoint(t[e]);return this}setFromCenterAndSize(t,e){let n=kg.copy(e).multiplyScalar(.5);return this.min.copy(t).sub(n),this.max.copy(t).add(n),this}clone(){return new this.constructor().copy(this)}copy(t){return this.min.copy(t.min),this.max.copy(t.max),this}makeEmpty(){return this.min.x=this.min.y=1/0,this.max.x=this.max.y=-1/0,this}isEmpty(){return this.max.x<this.min.x||this.max.y<this.min.y}getCenter(t){return this.isEmpty()?t.set(0,0):t.addVectors(this.min,this.max).multiplyScalar(.5)}getSize(t){return this.isEmpty()?t.set(0,0):t.subVectors(this.max,this.min)}expandByPoint(t){return this.min.min(t),this.max.max(t),this}expandByVector(t){return this.min.sub(t),this.max.add(t),this}expandByScalar(t){return this.min.addScalar(-t),this.max.addScalar(t),this}containsPoint(t){return t.x>=this.min.x&&t.x<=this.max.x&&t.y>=this.min.y&&t.y<=this.max.y}containsBox(t){return this.min.x<=t.min.x&&t.max.x<=this.max.x&&this.min.y<=t.min.y&&t.max.y<=this.max.y}getParameter(t,e){return e.set((t.x-this.min.x)/(this.max.x-this.min.x),(t.y-this.min.y)/(this.max.y-this.min.y))}intersectsBox(t){return t.max.x>=this.min.x&&t.min.x<=this.max.x&&t.max.y>=this.min.y&&t.min.y<=this.max.y}clampPoint(t,e){return e.copy(t).clamp(this.min,this.max)}distanceToPoint(t){return this.clampPoint(t,kg).distanceTo(t)}intersect(t){return this.min.max(t.min),this.max.min(t.max),this.isEmpty()&&this.makeEmpty(),this}union(t){return this.min.min(t.min),this.max.max(t.max),this}translate(t){return this.min.add(t),this.max.add(t),this}equals(t){return t.min.equals(this.min)&&t.max.equals(this.max)}};function ld(i,t,e,n){let s=cS(n);switch(e){case Jf:return i*t;case jf:return i*t/s.components*s.byteLength;case Bc:return i*t/s.components*s.byteLength;case Ys:return i*t*2/s.components*s.byteLength;case kc:return i*t*2/s.components*s.byteLength;case Kf:return i*t*3/s.components*s.byteLength;case Ui:return i*t*4/s.components*s.byteLength;case zc:return i*t*4/s.components*s.byteLength;case ya:case ba:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*8;case Sa:case Ma:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*16;case Hc:case Wc:return Math.max(i,16)*Math.max(t,8)/4;case Vc:case Gc:return Math.max(i,8)*Math.max(t,8)/2;case Xc:case qc:case Yc:case Zc:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*8;case $c:case wa:case Jc:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*16;case Kc:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*16;case jc:return Math.floor((i+4)/5)*Math.floor((t+3)/4)*16;case Qc:return Math.floor((i+4)/5)*Math.floor((t+4)/5)*16;case th:return Math.floor((i+5)/6)*Math.floor((t+4)/5)*16;case eh:return Math.floor((i+5)/6)*Math.floor((t+5)/6)*16;case nh:return Math.floor((i+7)/8)*Math.floor((t+4)/5)*16;case ih:return Math.floor((i+7)/8)*Math.floor((t+5)/6)*16;case sh:return Math.floor((i+7)/8)*Math.floor((t+7)/8)*16;case rh:return Math.floor((i+9)/10)*Math.floor((t+4)/5)*16;case oh:return Math.floor((i+9)/10)*Math.floor((t+5)/6)*16;case ah:return Math.floor((i+9)/10)*Math.floor((t+7)/8)*16;case lh:return Math.floor((i+9)/10)*Math.floor((t+9)/10)*16;case ch:return Math.floor((i+11)/12)*Math.floor((t+9)/10)*16;case hh:return Math.floor((i+11)/12)*Math.floor((t+11)/12)*16;case uh:case fh:case dh:return Math.ceil(i/4)*Math.ceil(t/4)*16;case ph:case mh:return Math.ceil(i/4)*Math.ceil(t/4)*8;case Ea:case gh:return Math.ceil(i/4)*Math.ceil(t/4)*16}throw new Error(`Unable to determine texture byte length for ${e} format.`)}function cS(i){switch(i){case fi:case qf:return{byteLength:1,components:1};case So:case $f:case Di:return{byteLength:2,components:1};case Fc:case Oc:return{byteLength:2,components:4};case Li:case Uc:case Ni:return{byteLength:4,components:1};case Yf:case Zf:return{byteLength:4,components:3}}throw new Error(`THREE.TextureUtils: Unknown texture type ${i}.`)}typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("register",{detail:{revision:"187"}}));typeof window<"u"&&(window.__THREE__?jt("WARNING: Multiple instances of Three.js being imported."):window.__THREE__="187");function Y0(){let i=null,t=!1,e=null,n=null;function s(r,o){n=i.requestAnimationFrame(s),e(r,o)}return{start:function(){t!==!0&&e!==null&&i!==null&&(n=i.requestAnimationFrame(s),t=!0)},stop:function(){i!==null&&i.cancelAnimationFrame(n),t=!1},setAnimationLoop:function(r){e=r},setContext:function(r){i=r}}}function uS(i){let t=new WeakMap;function e(a,l){let c=a.array,h=a.usage,f=c.byteLength,u=i.createBuffer();i.bindBuffer(l,u),i.bufferData(l,c,h),a.onUploadCallback();let d;if(c instanceof Float32Array)d=i.FLOAT;else if(typeof Float16Array<"u"&&c instanceof Float16Array)d=i.HALF_FLOAT;else if(c instanceof Uint16Array)a.isFloat16BufferAttribute?d=i.HALF_FLOAT:d=i.UNSIGNED_SHORT;else if(c instanceof Int16Array)d=i.SHORT;else if(c instanceof Uint32Array)d=i.UNSIGNED_INT;else if(c instanceof Int32Array)d=i.INT;else if(c instanceof Int8Array)d=i.BYTE;else if(c instanceof Uint8Array)d=i.UNSIGNED_BYTE;else if(c instanceof Uint8ClampedArray)d=i.UNSIGNED_BYTE;else throw new Error("THREE.WebGLAttributes: Unsupported buffer data format: "+c);return{buffer:u,type:d,bytesPerElement:c.BYTES_PER_ELEMENT,version:a.version,size:f}}function n(a,l,c){let h=l.array,f=l.updateRanges;if(i.bindBuffer(c,a),f.length===0)i.bufferSubData(c,0,h);else{f.sort((d,g)=>d.start-g.start);let u=0;for(let d=1;d<f.length;d++){let g=f[u],M=f[d];M.start<=g.start+g.count+1?g.count=Math.max(g.count,M.start+M.count-g.start):(++u,f[u]=M)}f.length=u+1;for(let d=0,g=f.length;d<g;d++){let M=f[d];i.bufferSubData(c,M.start*h.BYTES_PER_ELEMENT,h,M.start,M.count)}l.clearUpdateRanges()}l.onUploadCallback()}function s(a){return a.isInterleavedBufferAttribute&&(a=a.data),t.get(a)}function r(a){a.isInterleavedBufferAttribute&&(a=a.data);let l=t.get(a);l&&(i.deleteBuffer(l.buffer),t.delete(a))}function o(a,l){if(a.isInterleavedBufferAttribute&&(a=a.data),a.isGLBufferAttribute){let h=t.get(a);(!h||h.version<a.version)&&t.set(a,{buffer:a.buffer,type:a.type,bytesPerElement:a.elementSize,version:a.version});return}let c=t.get(a);if(c===void 0)t.set(a,e(a,l));else if(c.version<a.version){if(c.size!==a.array.byteLength)throw new Error("THREE.WebGLAttributes: The size of the buffer attribute's array buffer does not match the original size. Resizing buffer attributes is not supported.");n(c.buffer,a,l),c.version=a.version}}return{get:s,remove:r,update:o}}var fS=`#ifdef USE_ALPHAHASH
	if ( diffuseColor.a < getAlphaHashThreshold( vPosition ) ) discard;
#endif`,dS=`#ifdef USE_ALPHAHASH
	const float ALPHA_HASH_SCALE = 0.05;
	float hash2D( vec2 value ) {
		return fract( 1.0e4 * sin( 17.0 * value.x + 0.1 * value.y ) * ( 0.1 + abs( sin( 13.0 * value.y + value.x ) ) ) );
	}
	float hash3D( vec3 value ) {
		return hash2D( vec2( hash2D( value.xy ), value.z ) );
	}
	float getAlphaHashThreshold( vec3 position ) {
		float maxDeriv = max(
			length( dFdx( position.xyz ) ),
			length( dFdy( position.xyz ) )
		);
		float pixScale = 1.0 / ( ALPHA_HASH_SCALE * maxDeriv );
		vec2 pixScales = vec2(
			exp2( floor( log2( pixScale ) ) ),
			exp2( ceil( log2( pixScale ) ) )
		);
		vec2 alpha = vec2(
			hash3D( floor( pixScales.x * position.xyz ) ),
			hash3D( floor( pixScales.y * position.xyz ) )
		);
		float lerpFactor = fract( log2( pixScale ) );
		float x = ( 1.0 - lerpFactor ) * alpha.x + lerpFactor * alpha.y;
		float a = min( lerpFactor, 1.0 - lerpFactor );
		vec3 cases = vec3(
			x * x / ( 2.0 * a * ( 1.0 - a ) ),
			( x - 0.5 * a ) / ( 1.0 - a ),
			1.0 - ( ( 1.0 - x ) * ( 1.0 - x ) / ( 2.0 * a * ( 1.0 - a ) ) )
		);
		float threshold = ( x < ( 1.0 - a ) )
			? ( ( x < a ) ? cases.x : cases.y )
			: cases.z;
		return clamp( threshold , 1.0e-6, 1.0 );
	}
#endif`,pS=`#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, vAlphaMapUv ).g;
#endif`,mS=`#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,gS=`#ifdef USE_ALPHATEST
	#ifdef ALPHA_TO_COVERAGE
	diffuseColor.a = smoothstep( alphaTest, alphaTest + fwidth( diffuseColor.a ), diffuseColor.a );
	if ( diffuseColor.a == 0.0 ) discard;
	#else
	if ( diffuseColor.a < alphaTest ) discard;
	#endif
#endif`,xS=`#ifdef USE_ALPHATEST
	uniform float alphaTest;
#endif`,_S=`#ifdef USE_AOMAP
	float ambientOcclusion = ( texture2D( aoMap, vAoMapUv ).r - 1.0 ) * aoMapIntensity + 1.0;
	reflectedLight.indirectDiffuse *= ambientOcclusion;
	#if defined( USE_CLEARCOAT ) 
		clearcoatSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_SHEEN ) 
		sheenSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_ENVMAP ) && defined( STANDARD )
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		reflectedLight.indirectSpecular *= computeSpecularOcclusion( dotNV, ambientOcclusion, material.roughness );
	#endif
#endif`,vS=`#ifdef USE_AOMAP
	uniform sampler2D aoMap;
	uniform float aoMapIntensity;
#endif`,yS=`#ifdef USE_BATCHING
	#if ! defined( GL_ANGLE_multi_draw )
	#define gl_DrawID _gl_DrawID
	uniform int _gl_DrawID;
	#endif
	uniform highp sampler2D batchingTexture;
	uniform highp usampler2D batchingIdTexture;
	mat4 getBatchingMatrix( const in float i ) {
		int size = textureSize( batchingTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( batchingTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( batchingTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( batchingTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( batchingTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
	float getIndirectIndex( const in int i ) {
		int size = textureSize( batchingIdTexture, 0 ).x;
		int x = i % size;
		int y = i / size;
		return float( texelFetch( batchingIdTexture, ivec2( x, y ), 0 ).r );
	}
#endif
#ifdef USE_BATCHING_COLOR
	uniform sampler2D batchingColorTexture;
	vec4 getBatchingColor( const in float i ) {
		int size = textureSize( batchingColorTexture, 0 ).x;
		int j = int( i );
		int x = j % size;
		int y = j / size;
		return texelFetch( batchingColorTexture, ivec2( x, y ), 0 );
	}
#endif`,bS=`#ifdef USE_BATCHING
	mat4 batchingMatrix = getBatchingMatrix( getIndirectIndex( gl_DrawID ) );
#endif`,SS=`vec3 transformed = vec3( position );
#ifdef USE_ALPHAHASH
	vPosition = vec3( position );
#endif`,MS=`vec3 objectNormal = vec3( normal );
#ifdef USE_TANGENT
	vec3 objectTangent = vec3( tangent.xyz );
#endif`,wS=`float G_BlinnPhong_Implicit( ) {
	return 0.25;
}
float D_BlinnPhong( const in float shininess, const in float dotNH ) {
	return RECIPROCAL_PI * ( shininess * 0.5 + 1.0 ) * pow( dotNH, shininess );
}
vec3 BRDF_BlinnPhong( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 specularColor, const in float shininess ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( specularColor, 1.0, dotVH );
	float G = G_BlinnPhong_Implicit( );
	float D = D_BlinnPhong( shininess, dotNH );
	return F * ( G * D );
} // validated`,ES=`#ifdef USE_IRIDESCENCE
	const mat3 XYZ_TO_REC709 = mat3(
		 3.2404542, -0.9692660,  0.0556434,
		-1.5371385,  1.8760108, -0.2040259,
		-0.4985314,  0.0415560,  1.0572252
	);
	vec3 Fresnel0ToIor( vec3 fresnel0 ) {
		vec3 sqrtF0 = sqrt( fresnel0 );
		return ( vec3( 1.0 ) + sqrtF0 ) / ( vec3( 1.0 ) - sqrtF0 );
	}
	vec3 IorToFresnel0( vec3 transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - vec3( incidentIor ) ) / ( transmittedIor + vec3( incidentIor ) ) );
	}
	float IorToFresnel0( float transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - incidentIor ) / ( transmittedIor + incidentIor ));
	}
	vec3 evalSensitivity( float OPD, vec3 shift ) {
		float phase = 2.0 * PI * OPD * 1.0e-9;
		vec3 val = vec3( 5.4856e-13, 4.4201e-13, 5.2481e-13 );
		vec3 pos = vec3( 1.6810e+06, 1.7953e+06, 2.2084e+06 );
		vec3 var = vec3( 4.3278e+09, 9.3046e+09, 6.6121e+09 );
		vec3 xyz = val * sqrt( 2.0 * PI * var ) * cos( pos * phase + shift ) * exp( - pow2( phase ) * var );
		xyz.x += 9.7470e-14 * sqrt( 2.0 * PI * 4.5282e+09 ) * cos( 2.2399e+06 * phase + shift[ 0 ] ) * exp( - 4.5282e+09 * pow2( phase ) );
		xyz /= 1.0685e-7;
		vec3 rgb = XYZ_TO_REC709 * xyz;
		return rgb;
	}
	vec3 evalIridescence( float outsideIOR, float eta2, float cosTheta1, float thinFilmThickness, vec3 baseF0 ) {
		vec3 I;
		float iridescenceIOR = mix( outsideIOR, eta2, smoothstep( 0.0, 0.03, thinFilmThickness ) );
		float sinTheta2Sq = pow2( outsideIOR / iridescenceIOR ) * ( 1.0 - pow2( cosTheta1 ) );
		float cosTheta2Sq = 1.0 - sinTheta2Sq;
		if ( cosTheta2Sq < 0.0 ) {
			return vec3( 1.0 );
		}
		float cosTheta2 = sqrt( cosTheta2Sq );
		float R0 = IorToFresnel0( iridescenceIOR, outsideIOR );
		float R12 = F_Schlick( R0, 1.0, cosTheta1 );
		float T121 = 1.0 - R12;
		float phi12 = 0.0;
		if ( iridescenceIOR < outsideIOR ) phi12 = PI;
		float phi21 = PI - phi12;
		vec3 baseIOR = Fresnel0ToIor( clamp( baseF0, 0.0, 0.9999 ) );		vec3 R1 = IorToFresnel0( baseIOR, iridescenceIOR );
		vec3 R23 = F_Schlick( R1, 1.0, cosTheta2 );
		vec3 phi23 = vec3( 0.0 );
		if ( baseIOR[ 0 ] < iridescenceIOR ) phi23[ 0 ] = PI;
		if ( baseIOR[ 1 ] < iridescenceIOR ) phi23[ 1 ] = PI;
		if ( baseIOR[ 2 ] < iridescenceIOR ) phi23[ 2 ] = PI;
		float OPD = 2.0 * iridescenceIOR * thinFilmThickness * cosTheta2;
		vec3 phi = vec3( phi21 ) + phi23;
		vec3 R123 = clamp( R12 * R23, 1e-5, 0.9999 );
		vec3 r123 = sqrt( R123 );
		vec3 Rs = pow2( T121 ) * R23 / ( vec3( 1.0 ) - R123 );
		vec3 C0 = R12 + Rs;
		I = C0;
		vec3 Cm = Rs - T121;
		for ( int m = 1; m <= 2; ++ m ) {
			Cm *= r123;
			vec3 Sm = 2.0 * evalSensitivity( float( m ) * OPD, float( m ) * phi );
			I += Cm * Sm;
		}
		return max( I, vec3( 0.0 ) );
	}
#endif`,TS=`#ifdef USE_BUMPMAP
	uniform sampler2D bumpMap;
	uniform float bumpScale;
	vec2 dHdxy_fwd() {
		vec2 dSTdx = dFdx( vBumpMapUv );
		vec2 dSTdy = dFdy( vBumpMapUv );
		float Hll = bumpScale * texture2D( bumpMap, vBumpMapUv ).x;
		float dBx = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdx ).x - Hll;
		float dBy = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdy ).x - Hll;
		return vec2( dBx, dBy );
	}
	vec3 perturbNormalArb( vec3 surf_pos, vec3 surf_norm, vec2 dHdxy, float faceDirection ) {
		vec3 vSigmaX = normalize( dFdx( surf_pos.xyz ) );
		vec3 vSigmaY = normalize( dFdy( surf_pos.xyz ) );
		vec3 vN = surf_norm;
		vec3 R1 = cross( vSigmaY, vN );
		vec3 R2 = cross( vN, vSigmaX );
		float fDet = dot( vSigmaX, R1 ) * faceDirection;
		vec3 vGrad = sign( fDet ) * ( dHdxy.x * R1 + dHdxy.y * R2 );
		return normalize( abs( fDet ) * surf_norm - vGrad );
	}
#endif`,AS=`#if NUM_CLIPPING_PLANES > 0
	vec4 plane;
	#ifdef ALPHA_TO_COVERAGE
		float distanceToPlane, distanceGradient;
		float clipOpacity = 1.0;
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
			distanceGradient = fwidth( distanceToPlane ) / 2.0;
			clipOpacity *= smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			if ( clipOpacity == 0.0 ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			float unionClipOpacity = 1.0;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
				distanceGradient = fwidth( distanceToPlane ) / 2.0;
				unionClipOpacity *= 1.0 - smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			}
			#pragma unroll_loop_end
			clipOpacity *= 1.0 - unionClipOpacity;
		#endif
		diffuseColor.a *= clipOpacity;
		if ( diffuseColor.a == 0.0 ) discard;
	#else
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			if ( dot( vClipPosition, plane.xyz ) > plane.w ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			bool clipped = true;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				clipped = ( dot( vClipPosition, plane.xyz ) > plane.w ) && clipped;
			}
			#pragma unroll_loop_end
			if ( clipped ) discard;
		#endif
	#endif
#endif`,RS=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
	uniform vec4 clippingPlanes[ NUM_CLIPPING_PLANES ];
#endif`,CS=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
#endif`,PS=`#if NUM_CLIPPING_PLANES > 0
	vClipPosition = - mvPosition.xyz;
#endif`,IS=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	diffuseColor *= vColor;
#endif`,LS=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	varying vec4 vColor;
#endif`,NS=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	varying vec4 vColor;
#endif`,DS=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	vColor = vec4( 1.0 );
#endif
#ifdef USE_COLOR_ALPHA
	vColor *= color;
#elif defined( USE_COLOR )
	vColor.rgb *= color;
#endif
#ifdef USE_INSTANCING_COLOR
	vColor.rgb *= instanceColor.rgb;
#endif
#ifdef USE_BATCHING_COLOR
	vColor *= getBatchingColor( getIndirectIndex( gl_DrawID ) );
#endif`,US=`#define PI 3.141592653589793
#define PI2 6.283185307179586
#define PI_HALF 1.5707963267948966
#define RECIPROCAL_PI 0.3183098861837907
#define RECIPROCAL_PI2 0.15915494309189535
#define EPSILON 1e-6
#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
#define whiteComplement( a ) ( 1.0 - saturate( a ) )
float pow2( const in float x ) { return x*x; }
vec3 pow2( const in vec3 x ) { return x*x; }
float pow3( const in float x ) { return x*x*x; }
float pow4( const in float x ) { float x2 = x*x; return x2*x2; }
float max3( const in vec3 v ) { return max( max( v.x, v.y ), v.z ); }
float average( const in vec3 v ) { return dot( v, vec3( 0.3333333 ) ); }
highp float rand( const in vec2 uv ) {
	const highp float a = 12.9898, b = 78.233, c = 43758.5453;
	highp float dt = dot( uv.xy, vec2( a,b ) ), sn = mod( dt, PI );
	return fract( sin( sn ) * c );
}
#ifdef HIGH_PRECISION
	float precisionSafeLength( vec3 v ) { return length( v ); }
#else
	float precisionSafeLength( vec3 v ) {
		float maxComponent = max3( abs( v ) );
		return length( v / maxComponent ) * maxComponent;
	}
#endif
struct IncidentLight {
	vec3 color;
	vec3 direction;
	bool visible;
};
struct ReflectedLight {
	vec3 directDiffuse;
	vec3 directSpecular;
	vec3 indirectDiffuse;
	vec3 indirectSpecular;
};
#ifdef USE_ALPHAHASH
	varying vec3 vPosition;
#endif
vec3 transformDirection( in vec3 dir, in mat4 matrix ) {
	return normalize( ( matrix * vec4( dir, 0.0 ) ).xyz );
}
#define inverseTransformDirection transformDirectionByInverseViewMatrix
vec3 transformNormalByInverseViewMatrix( in vec3 normal, in mat4 viewMatrix ) {
	return normalize( ( vec4( normal, 0.0 ) * viewMatrix ).xyz );
}
vec3 transformDirectionByInverseViewMatrix( in vec3 dir, in mat4 viewMatrix ) {
	return normalize( ( vec4( dir, 0.0 ) * viewMatrix ).xyz );
}
bool isPerspectiveMatrix( mat4 m ) {
	return m[ 2 ][ 3 ] == - 1.0;
}
vec2 equirectUv( in vec3 dir ) {
	float u = atan( dir.z, dir.x ) * RECIPROCAL_PI2 + 0.5;
	float v = asin( clamp( dir.y, - 1.0, 1.0 ) ) * RECIPROCAL_PI + 0.5;
	return vec2( u, v );
}
vec3 BRDF_Lambert( const in vec3 diffuseColor ) {
	return RECIPROCAL_PI * diffuseColor;
}
vec3 F_Schlick( const in vec3 f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
}
float F_Schlick( const in float f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
} // validated`,FS=`vec3 transformedNormal = objectNormal;
#ifdef USE_TANGENT
	vec3 transformedTangent = objectTangent;
#endif
#ifdef USE_BATCHING
	mat3 bm = mat3( batchingMatrix );
	transformedNormal /= vec3( dot( bm[ 0 ], bm[ 0 ] ), dot( bm[ 1 ], bm[ 1 ] ), dot( bm[ 2 ], bm[ 2 ] ) );
	transformedNormal = bm * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = bm * transformedTangent;
	#endif
#endif
#ifdef USE_INSTANCING
	mat3 im = mat3( instanceMatrix );
	transformedNormal /= vec3( dot( im[ 0 ], im[ 0 ] ), dot( im[ 1 ], im[ 1 ] ), dot( im[ 2 ], im[ 2 ] ) );
	transformedNormal = im * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = im * transformedTangent;
	#endif
#endif
transformedNormal = normalMatrix * transformedNormal;
#ifdef FLIP_SIDED
	transformedNormal = - transformedNormal;
#endif
#ifdef USE_TANGENT
	transformedTangent = ( modelViewMatrix * vec4( transformedTangent, 0.0 ) ).xyz;
#endif`,OS=`#ifdef USE_DISPLACEMENTMAP
	uniform sampler2D displacementMap;
	uniform float displacementScale;
	uniform float displacementBias;
#endif`,BS=`#ifdef USE_DISPLACEMENTMAP
	transformed += normalize( objectNormal ) * ( texture2D( displacementMap, vDisplacementMapUv ).x * displacementScale + displacementBias );
#endif`,kS=`#ifdef USE_EMISSIVEMAP
	vec4 emissiveColor = texture2D( emissiveMap, vEmissiveMapUv );
	#ifdef DECODE_VIDEO_TEXTURE_EMISSIVE
		emissiveColor = sRGBTransferEOTF( emissiveColor );
	#endif
	totalEmissiveRadiance *= emissiveColor.rgb;
#endif`,zS=`#ifdef USE_EMISSIVEMAP
	uniform sampler2D emissiveMap;
#endif`,VS="gl_FragColor = linearToOutputTexel( gl_FragColor );",HS=`vec4 LinearTransferOETF( in vec4 value ) {
	return value;
}
vec4 sRGBTransferEOTF( in vec4 value ) {
	return vec4( mix( pow( value.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), value.rgb * 0.0773993808, vec3( lessThanEqual( value.rgb, vec3( 0.04045 ) ) ) ), value.a );
}
vec4 sRGBTransferOETF( in vec4 value ) {
	return vec4( mix( pow( value.rgb, vec3( 0.41666 ) ) * 1.055 - vec3( 0.055 ), value.rgb * 12.92, vec3( lessThanEqual( value.rgb, vec3( 0.0031308 ) ) ) ), value.a );
}`,GS=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vec3 cameraToFrag;
		if ( isOrthographic ) {
			cameraToFrag = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToFrag = normalize( vWorldPosition - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vec3 reflectVec = reflect( cameraToFrag, worldNormal );
		#else
			vec3 reflectVec = refract( cameraToFrag, worldNormal, refractionRatio );
		#endif
	#else
		vec3 reflectVec = vReflect;
	#endif
	#ifdef ENVMAP_TYPE_CUBE
		vec4 envColor = textureCube( envMap, envMapRotation * reflectVec );
		#ifdef ENVMAP_BLENDING_MULTIPLY
			outgoingLight = mix( outgoingLight, outgoingLight * envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_MIX )
			outgoingLight = mix( outgoingLight, envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_ADD )
			outgoingLight += envColor.xyz * specularStrength * reflectivity;
		#endif
	#endif
#endif`,WS=`#ifdef USE_ENVMAP
	uniform float envMapIntensity;
	uniform mat3 envMapRotation;
	uniform samplerCube envMap;
	#ifdef ENVMAP_TYPE_PMREM
		float roughnessToMip( const in float roughness ) {
			float r = clamp( roughness, 0.0, 1.0 );
			return ENVMAP_MAX_LOD * r * ( 2.0 - r );
		}
	#endif
#endif`,XS=`#ifdef USE_ENVMAP
	uniform float reflectivity;
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		varying vec3 vWorldPosition;
		uniform float refractionRatio;
	#else
		varying vec3 vReflect;
	#endif
#endif`,qS=`#ifdef USE_ENVMAP
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		
		varying vec3 vWorldPosition;
	#else
		varying vec3 vReflect;
		uniform float refractionRatio;
	#endif
#endif`,$S=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vWorldPosition = worldPosition.xyz;
	#else
		vec3 cameraToVertex;
		if ( isOrthographic ) {
			cameraToVertex = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToVertex = normalize( worldPosition.xyz - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vReflect = reflect( cameraToVertex, worldNormal );
		#else
			vReflect = refract( cameraToVertex, worldNormal, refractionRatio );
		#endif
	#endif
#endif`,YS=`#ifdef USE_FOG
	vFogDepth = - mvPosition.z;
#endif`,ZS=`#ifdef USE_FOG
	varying float vFogDepth;
#endif`,JS=`#ifdef USE_FOG
	#ifdef FOG_EXP2
		float fogFactor = 1.0 - exp( - fogDensity * fogDensity * vFogDepth * vFogDepth );
	#else
		float fogFactor = smoothstep( fogNear, fogFar, vFogDepth );
	#endif
	gl_FragColor.rgb = mix( gl_FragColor.rgb, fogColor, fogFactor );
#endif`,KS=`#ifdef USE_FOG
	uniform vec3 fogColor;
	varying float vFogDepth;
	#ifdef FOG_EXP2
		uniform float fogDensity;
	#else
		uniform float fogNear;
		uniform float fogFar;
	#endif
#endif`,jS=`#ifdef USE_GRADIENTMAP
	uniform sampler2D gradientMap;
#endif
vec3 getGradientIrradiance( vec3 normal, vec3 lightDirection ) {
	float dotNL = dot( normal, lightDirection );
	vec2 coord = vec2( dotNL * 0.5 + 0.5, 0.0 );
	#ifdef USE_GRADIENTMAP
		return vec3( texture2D( gradientMap, coord ).r );
	#else
		vec2 fw = fwidth( coord ) * 0.5;
		return mix( vec3( 0.7 ), vec3( 1.0 ), smoothstep( 0.7 - fw.x, 0.7 + fw.x, coord.x ) );
	#endif
}`,QS=`#ifdef USE_LIGHTMAP
	uniform sampler2D lightMap;
	uniform float lightMapIntensity;
#endif`,tM=`LambertMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularStrength = specularStrength;`,eM=`varying vec3 vViewPosition;
struct LambertMaterial {
	vec3 diffuseColor;
	float specularStrength;
};
void RE_Direct_Lambert( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Lambert( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Lambert
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Lambert`,nM=`uniform bool receiveShadow;
uniform vec3 ambientLightColor;
#if defined( USE_LIGHT_PROBES )
	uniform vec3 lightProbe[ 9 ];
#endif
vec3 shGetIrradianceAt( in vec3 normal, in vec3 shCoefficients[ 9 ] ) {
	float x = normal.x, y = normal.y, z = normal.z;
	vec3 result = shCoefficients[ 0 ] * 0.886227;
	result += shCoefficients[ 1 ] * 2.0 * 0.511664 * y;
	result += shCoefficients[ 2 ] * 2.0 * 0.511664 * z;
	result += shCoefficients[ 3 ] * 2.0 * 0.511664 * x;
	result += shCoefficients[ 4 ] * 2.0 * 0.429043 * x * y;
	result += shCoefficients[ 5 ] * 2.0 * 0.429043 * y * z;
	result += shCoefficients[ 6 ] * ( 0.743125 * z * z - 0.247708 );
	result += shCoefficients[ 7 ] * 2.0 * 0.429043 * x * z;
	result += shCoefficients[ 8 ] * 0.429043 * ( x * x - y * y );
	return result;
}
vec3 getLightProbeIrradiance( const in vec3 lightProbe[ 9 ], const in vec3 normal ) {
	vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec3 irradiance = shGetIrradianceAt( worldNormal, lightProbe );
	return irradiance;
}
vec3 getAmbientLightIrradiance( const in vec3 ambientLightColor ) {
	vec3 irradiance = ambientLightColor;
	return irradiance;
}
float getDistanceAttenuation( const in float lightDistance, const in float cutoffDistance, const in float decayExponent ) {
	float distanceFalloff = 1.0 / max( pow( lightDistance, decayExponent ), 0.01 );
	if ( cutoffDistance > 0.0 ) {
		distanceFalloff *= pow2( saturate( 1.0 - pow4( lightDistance / cutoffDistance ) ) );
	}
	return distanceFalloff;
}
float getSpotAttenuation( const in float coneCosine, const in float penumbraCosine, const in float angleCosine ) {
	return smoothstep( coneCosine, penumbraCosine, angleCosine );
}
#if NUM_SUN_LIGHTS > 0
	struct SunLight {
		vec3 direction;
		vec3 color;
	};
	uniform SunLight sunLights[ NUM_SUN_LIGHTS ];
	void getSunLightInfo( const in SunLight sunLight, out IncidentLight light ) {
		light.color = sunLight.color;
		light.direction = sunLight.direction;
		light.visible = true;
	}
#endif
#if NUM_DIR_LIGHTS > 0
	struct DirectionalLight {
		vec3 direction;
		vec3 color;
	};
	uniform DirectionalLight directionalLights[ NUM_DIR_LIGHTS ];
	void getDirectionalLightInfo( const in DirectionalLight directionalLight, out IncidentLight light ) {
		light.color = directionalLight.color;
		light.direction = directionalLight.direction;
		light.visible = true;
	}
#endif
#if NUM_POINT_LIGHTS > 0
	struct PointLight {
		vec3 position;
		vec3 color;
		float distance;
		float decay;
	};
	uniform PointLight pointLights[ NUM_POINT_LIGHTS ];
	void getPointLightInfo( const in PointLight pointLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = pointLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float lightDistance = length( lVector );
		light.color = pointLight.color;
		light.color *= getDistanceAttenuation( lightDistance, pointLight.distance, pointLight.decay );
		light.visible = ( light.color != vec3( 0.0 ) );
	}
#endif
#if NUM_SPOT_LIGHTS > 0
	struct SpotLight {
		vec3 position;
		vec3 direction;
		vec3 color;
		float distance;
		float decay;
		float coneCos;
		float penumbraCos;
	};
	uniform SpotLight spotLights[ NUM_SPOT_LIGHTS ];
	void getSpotLightInfo( const in SpotLight spotLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = spotLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float angleCos = dot( light.direction, spotLight.direction );
		float spotAttenuation = getSpotAttenuation( spotLight.coneCos, spotLight.penumbraCos, angleCos );
		if ( spotAttenuation > 0.0 ) {
			float lightDistance = length( lVector );
			light.color = spotLight.color * spotAttenuation;
			light.color *= getDistanceAttenuation( lightDistance, spotLight.distance, spotLight.decay );
			light.visible = ( light.color != vec3( 0.0 ) );
		} else {
			light.color = vec3( 0.0 );
			light.visible = false;
		}
	}
#endif
#if NUM_RECT_AREA_LIGHTS > 0
	struct RectAreaLight {
		vec3 color;
		vec3 position;
		vec3 halfWidth;
		vec3 halfHeight;
	};
	uniform sampler2D ltc_1;	uniform sampler2D ltc_2;
	uniform RectAreaLight rectAreaLights[ NUM_RECT_AREA_LIGHTS ];
#endif
#if NUM_HEMI_LIGHTS > 0
	struct HemisphereLight {
		vec3 direction;
		vec3 skyColor;
		vec3 groundColor;
	};
	uniform HemisphereLight hemisphereLights[ NUM_HEMI_LIGHTS ];
	vec3 getHemisphereLightIrradiance( const in HemisphereLight hemiLight, const in vec3 normal ) {
		float dotNL = dot( normal, hemiLight.direction );
		float hemiDiffuseWeight = 0.5 * dotNL + 0.5;
		vec3 irradiance = mix( hemiLight.groundColor, hemiLight.skyColor, hemiDiffuseWeight );
		return irradiance;
	}
#endif
#include <lightprobes_pars_fragment>`,iM=`#ifdef USE_ENVMAP
	vec3 getIBLIrradiance( const in vec3 normal ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * worldNormal, ENVMAP_MAX_LOD );
			return PI * envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	vec3 getIBLRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 reflectVec = reflect( - viewDir, normal );
			reflectVec = normalize( mix( reflectVec, normal, pow4( roughness ) ) );
			reflectVec = transformDirectionByInverseViewMatrix( reflectVec, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * reflectVec, roughnessToMip( roughness ) );
			return envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	#ifdef USE_RETROREFLECTION
		vec3 getIBLRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 retroVec = normalize( mix( viewDir, normal, pow4( roughness ) ) );
				retroVec = transformDirectionByInverseViewMatrix( retroVec, viewMatrix );
				vec4 envMapColor = textureLod( envMap, envMapRotation * retroVec, roughnessToMip( roughness ) );
				return envMapColor.rgb * envMapIntensity;
			#else
				return vec3( 0.0 );
			#endif
		}
	#endif
	#ifdef USE_ANISOTROPY
		vec3 getIBLAnisotropyRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 bentNormal = cross( bitangent, viewDir );
				bentNormal = normalize( cross( bentNormal, bitangent ) );
				bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
				return getIBLRadiance( viewDir, bentNormal, roughness );
			#else
				return vec3( 0.0 );
			#endif
		}
		#ifdef USE_RETROREFLECTION
			vec3 getIBLAnisotropyRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
				#ifdef ENVMAP_TYPE_PMREM
					vec3 bentNormal = cross( bitangent, viewDir );
					bentNormal = normalize( cross( bentNormal, bitangent ) );
					bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
					return getIBLRetroRadiance( viewDir, bentNormal, roughness );
				#else
					return vec3( 0.0 );
				#endif
			}
		#endif
	#endif
#endif`,sM=`ToonMaterial material;
material.diffuseColor = diffuseColor.rgb;`,rM=`varying vec3 vViewPosition;
struct ToonMaterial {
	vec3 diffuseColor;
};
void RE_Direct_Toon( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 irradiance = getGradientIrradiance( geometryNormal, directLight.direction ) * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Toon( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Toon
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Toon`,oM=`BlinnPhongMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularColor = specular;
material.specularShininess = shininess;
material.specularStrength = specularStrength;`,aM=`varying vec3 vViewPosition;
struct BlinnPhongMaterial {
	vec3 diffuseColor;
	vec3 specularColor;
	float specularShininess;
	float specularStrength;
};
void RE_Direct_BlinnPhong( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
	reflectedLight.directSpecular += irradiance * BRDF_BlinnPhong( directLight.direction, geometryViewDir, geometryNormal, material.specularColor, material.specularShininess ) * material.specularStrength;
}
void RE_IndirectDiffuse_BlinnPhong( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_BlinnPhong
#define RE_IndirectDiffuse		RE_IndirectDiffuse_BlinnPhong`,lM=`PhysicalMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.diffuseContribution = diffuseColor.rgb * ( 1.0 - metalnessFactor );
material.metalness = metalnessFactor;
vec3 dxy = max( abs( dFdx( nonPerturbedNormal ) ), abs( dFdy( nonPerturbedNormal ) ) );
float geometryRoughness = max( max( dxy.x, dxy.y ), dxy.z );
material.roughness = max( roughnessFactor, 0.045 );
material.roughness += geometryRoughness;
material.roughness = min( material.roughness, 1.0 );
#ifdef USE_DIFFUSE_ROUGHNESS
	float diffuseRoughnessFactor = diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		diffuseRoughnessFactor *= texture2D( diffuseRoughnessMap, vDiffuseRoughnessMapUv ).r;
	#endif
	material.diffuseRoughness = saturate( diffuseRoughnessFactor );
#endif
#ifdef IOR
	material.ior = ior;
	#ifdef USE_SPECULAR
		float specularIntensityFactor = specularIntensity;
		vec3 specularColorFactor = specularColor;
		#ifdef USE_SPECULAR_COLORMAP
			specularColorFactor *= texture2D( specularColorMap, vSpecularColorMapUv ).rgb;
		#endif
		#ifdef USE_SPECULAR_INTENSITYMAP
			specularIntensityFactor *= texture2D( specularIntensityMap, vSpecularIntensityMapUv ).a;
		#endif
		material.specularF90 = mix( specularIntensityFactor, 1.0, metalnessFactor );
	#else
		float specularIntensityFactor = 1.0;
		vec3 specularColorFactor = vec3( 1.0 );
		material.specularF90 = 1.0;
	#endif
	material.specularColor = min( pow2( ( material.ior - 1.0 ) / ( material.ior + 1.0 ) ) * specularColorFactor, vec3( 1.0 ) ) * specularIntensityFactor;
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
#else
	material.specularColor = vec3( 0.04 );
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
	material.specularF90 = 1.0;
#endif
#ifdef USE_CLEARCOAT
	material.clearcoat = clearcoat;
	material.clearcoatRoughness = clearcoatRoughness;
	material.clearcoatF0 = vec3( 0.04 );
	material.clearcoatF90 = 1.0;
	#ifdef USE_CLEARCOATMAP
		material.clearcoat *= texture2D( clearcoatMap, vClearcoatMapUv ).x;
	#endif
	#ifdef USE_CLEARCOAT_ROUGHNESSMAP
		material.clearcoatRoughness *= texture2D( clearcoatRoughnessMap, vClearcoatRoughnessMapUv ).y;
	#endif
	material.clearcoat = saturate( material.clearcoat );	material.clearcoatRoughness = max( material.clearcoatRoughness, 0.045 );
	material.clearcoatRoughness += geometryRoughness;
	material.clearcoatRoughness = min( material.clearcoatRoughness, 1.0 );
#endif
#ifdef USE_DISPERSION
	material.dispersion = dispersion;
#endif
#ifdef USE_RETROREFLECTION
	material.retroreflectivity = retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	material.iridescence = iridescence;
	material.iridescenceIOR = iridescenceIOR;
	#ifdef USE_IRIDESCENCEMAP
		material.iridescence *= texture2D( iridescenceMap, vIridescenceMapUv ).r;
	#endif
	#ifdef USE_IRIDESCENCE_THICKNESSMAP
		material.iridescenceThickness = (iridescenceThicknessMaximum - iridescenceThicknessMinimum) * texture2D( iridescenceThicknessMap, vIridescenceThicknessMapUv ).g + iridescenceThicknessMinimum;
	#else
		material.iridescenceThickness = iridescenceThicknessMaximum;
	#endif
#endif
#ifdef USE_SHEEN
	material.sheenColor = sheenColor;
	#ifdef USE_SHEEN_COLORMAP
		material.sheenColor *= texture2D( sheenColorMap, vSheenColorMapUv ).rgb;
	#endif
	material.sheenRoughness = clamp( sheenRoughness, 0.0001, 1.0 );
	#ifdef USE_SHEEN_ROUGHNESSMAP
		material.sheenRoughness *= texture2D( sheenRoughnessMap, vSheenRoughnessMapUv ).a;
	#endif
#endif
#ifdef USE_ANISOTROPY
	#ifdef USE_ANISOTROPYMAP
		mat2 anisotropyMat = mat2( anisotropyVector.x, anisotropyVector.y, - anisotropyVector.y, anisotropyVector.x );
		vec3 anisotropyPolar = texture2D( anisotropyMap, vAnisotropyMapUv ).rgb;
		vec2 anisotropyV = anisotropyMat * normalize( 2.0 * anisotropyPolar.rg - vec2( 1.0 ) ) * anisotropyPolar.b;
	#else
		vec2 anisotropyV = anisotropyVector;
	#endif
	material.anisotropy = length( anisotropyV );
	if( material.anisotropy == 0.0 ) {
		anisotropyV = vec2( 1.0, 0.0 );
	} else {
		anisotropyV /= material.anisotropy;
		material.anisotropy = saturate( material.anisotropy );
	}
	material.alphaT = mix( pow2( material.roughness ), 1.0, pow2( material.anisotropy ) );
	material.anisotropyT = tbn[ 0 ] * anisotropyV.x + tbn[ 1 ] * anisotropyV.y;
	material.anisotropyB = tbn[ 1 ] * anisotropyV.x - tbn[ 0 ] * anisotropyV.y;
#endif`,cM=`uniform sampler2D dfgLUT;
struct PhysicalMaterial {
	vec3 diffuseColor;
	vec3 diffuseContribution;
	vec3 specularColor;
	vec3 specularColorBlended;
	float roughness;
	float metalness;
	float specularF90;
	float dispersion;
	vec2 dfg;
	vec3 multiScatteringCompensation;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float diffuseRoughness;
	#endif
	#ifdef USE_RETROREFLECTION
		float retroreflectivity;
	#endif
	#ifdef USE_CLEARCOAT
		float clearcoat;
		float clearcoatRoughness;
		vec3 clearcoatF0;
		float clearcoatF90;
	#endif
	#ifdef USE_IRIDESCENCE
		float iridescence;
		float iridescenceIOR;
		float iridescenceThickness;
		vec3 iridescenceFresnel;
		vec3 iridescenceF0Dielectric;
		vec3 iridescenceF0Metallic;
	#endif
	#ifdef USE_SHEEN
		vec3 sheenColor;
		float sheenRoughness;
	#endif
	#ifdef IOR
		float ior;
	#endif
	#ifdef USE_TRANSMISSION
		float transmission;
		float transmissionAlpha;
		float thickness;
		float attenuationDistance;
		vec3 attenuationColor;
	#endif
	#ifdef USE_ANISOTROPY
		float anisotropy;
		float alphaT;
		vec3 anisotropyT;
		vec3 anisotropyB;
	#endif
};
vec3 clearcoatSpecularDirect = vec3( 0.0 );
vec3 clearcoatSpecularIndirect = vec3( 0.0 );
vec3 sheenSpecularDirect = vec3( 0.0 );
vec3 sheenSpecularIndirect = vec3(0.0 );
vec3 Schlick_to_F0( const in vec3 f, const in float f90, const in float dotVH ) {
    float x = clamp( 1.0 - dotVH, 0.0, 1.0 );
    float x2 = x * x;
    float x5 = clamp( x * x2 * x2, 0.0, 0.9999 );
    return ( f - vec3( f90 ) * x5 ) / ( 1.0 - x5 );
}
#ifdef USE_DIFFUSE_ROUGHNESS
	const float EON_EPSILON = 1e-7;
	float FON_DirectionalAlbedo( const in float mu, const in float roughness, const in float A ) {
		float muComp = 1.0 - mu;
		float gOverPi = muComp * ( 0.0571085289 + muComp * ( 0.491881867 + muComp * ( - 0.332181442 + muComp * 0.0714429953 ) ) );
		return A * ( 1.0 + roughness * gOverPi );
	}
	vec3 BRDF_EON( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 diffuseColor, const in float roughness ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return BRDF_Lambert( rho );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float s = dot( lightDir, viewDir ) - dotNL * dotNV;
		float sOverT = ( s > 0.0 ) ? s / max( max( dotNL, dotNV ), EON_EPSILON ) : s;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		vec3 singleScatter = rho * RECIPROCAL_PI * A * ( 1.0 + roughness * sOverT );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		float albedoV = FON_DirectionalAlbedo( dotNV, roughness, A );
		float albedoL = FON_DirectionalAlbedo( dotNL, roughness, A );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		vec3 multiScatter = rhoMultiScatter * RECIPROCAL_PI
			* max( EON_EPSILON, 1.0 - albedoV )
			* max( EON_EPSILON, 1.0 - albedoL )
			/ max( EON_EPSILON, 1.0 - averageAlbedo );
		return singleScatter + multiScatter;
	}
	vec3 EON_DirectionalAlbedo( const in vec3 diffuseColor, const in float roughness, const in float dotNV ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return rho;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		float directionalAlbedo = FON_DirectionalAlbedo( dotNV, roughness, A );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		return rho * directionalAlbedo + rhoMultiScatter * ( 1.0 - directionalAlbedo );
	}
#endif
float V_GGX_SmithCorrelated( const in float alpha, const in float dotNL, const in float dotNV ) {
	float a2 = pow2( alpha );
	float gv = dotNL * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNV ) );
	float gl = dotNV * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNL ) );
	return 0.5 / max( gv + gl, EPSILON );
}
float D_GGX( const in float alpha, const in float dotNH ) {
	float a2 = pow2( alpha );
	float denom = pow2( dotNH ) * ( a2 - 1.0 ) + 1.0;
	return RECIPROCAL_PI * a2 / pow2( denom );
}
#ifdef USE_ANISOTROPY
	float V_GGX_SmithCorrelated_Anisotropic( const in float alphaT, const in float alphaB, const in float dotTV, const in float dotBV, const in float dotTL, const in float dotBL, const in float dotNV, const in float dotNL ) {
		float gv = dotNL * length( vec3( alphaT * dotTV, alphaB * dotBV, dotNV ) );
		float gl = dotNV * length( vec3( alphaT * dotTL, alphaB * dotBL, dotNL ) );
		return 0.5 / max( gv + gl, EPSILON );
	}
	float D_GGX_Anisotropic( const in float alphaT, const in float alphaB, const in float dotNH, const in float dotTH, const in float dotBH ) {
		float a2 = alphaT * alphaB;
		highp vec3 v = vec3( alphaB * dotTH, alphaT * dotBH, a2 * dotNH );
		highp float v2 = dot( v, v );
		float w2 = a2 / v2;
		return RECIPROCAL_PI * a2 * pow2 ( w2 );
	}
#endif
#ifdef USE_CLEARCOAT
	vec3 BRDF_GGX_Clearcoat( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material) {
		vec3 f0 = material.clearcoatF0;
		float f90 = material.clearcoatF90;
		float roughness = max( material.clearcoatRoughness, 0.045 );
		float alpha = pow2( roughness );
		vec3 halfDir = normalize( lightDir + viewDir );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float dotNH = saturate( dot( normal, halfDir ) );
		float dotVH = saturate( dot( viewDir, halfDir ) );
		vec3 F = F_Schlick( f0, f90, dotVH );
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
		return F * ( V * D );
	}
#endif
vec3 BRDF_GGX( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material ) {
	vec3 f0 = material.specularColorBlended;
	float f90 = material.specularF90;
	float roughness = max( material.roughness, 0.045 );
	float alpha = pow2( roughness );
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( f0, f90, dotVH );
	#ifdef USE_IRIDESCENCE
		F = mix( F, material.iridescenceFresnel, material.iridescence );
	#endif
	#ifdef USE_ANISOTROPY
		float dotTL = dot( material.anisotropyT, lightDir );
		float dotTV = dot( material.anisotropyT, viewDir );
		float dotTH = dot( material.anisotropyT, halfDir );
		float dotBL = dot( material.anisotropyB, lightDir );
		float dotBV = dot( material.anisotropyB, viewDir );
		float dotBH = dot( material.anisotropyB, halfDir );
		float alphaT = max( material.alphaT, alpha );
		float V = V_GGX_SmithCorrelated_Anisotropic( alphaT, alpha, dotTV, dotBV, dotTL, dotBL, dotNV, dotNL );
		float D = D_GGX_Anisotropic( alphaT, alpha, dotNH, dotTH, dotBH );
	#else
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
	#endif
	return F * ( V * D );
}
vec2 LTC_Uv( const in vec3 N, const in vec3 V, const in float roughness ) {
	const float LUT_SIZE = 64.0;
	const float LUT_SCALE = ( LUT_SIZE - 1.0 ) / LUT_SIZE;
	const float LUT_BIAS = 0.5 / LUT_SIZE;
	float dotNV = saturate( dot( N, V ) );
	vec2 uv = vec2( roughness, sqrt( 1.0 - dotNV ) );
	uv = uv * LUT_SCALE + LUT_BIAS;
	return uv;
}
float LTC_ClippedSphereFormFactor( const in vec3 f ) {
	float l = length( f );
	return max( ( l * l + f.z ) / ( l + 1.0 ), 0.0 );
}
vec3 LTC_EdgeVectorFormFactor( const in vec3 v1, const in vec3 v2 ) {
	float x = dot( v1, v2 );
	float y = abs( x );
	float a = 0.8543985 + ( 0.4965155 + 0.0145206 * y ) * y;
	float b = 3.4175940 + ( 4.1616724 + y ) * y;
	float v = a / b;
	float theta_sintheta = ( x > 0.0 ) ? v : 0.5 * inversesqrt( max( 1.0 - x * x, 1e-7 ) ) - v;
	return cross( v1, v2 ) * theta_sintheta;
}
vec3 LTC_Evaluate( const in vec3 N, const in vec3 V, const in vec3 P, const in mat3 mInv, const in vec3 rectCoords[ 4 ] ) {
	vec3 v1 = rectCoords[ 1 ] - rectCoords[ 0 ];
	vec3 v2 = rectCoords[ 3 ] - rectCoords[ 0 ];
	vec3 lightNormal = cross( v1, v2 );
	if( dot( lightNormal, P - rectCoords[ 0 ] ) < 0.0 ) return vec3( 0.0 );
	vec3 T1, T2;
	T1 = normalize( V - N * dot( V, N ) );
	T2 = - cross( N, T1 );
	mat3 mat = mInv * transpose( mat3( T1, T2, N ) );
	vec3 coords[ 4 ];
	coords[ 0 ] = mat * ( rectCoords[ 0 ] - P );
	coords[ 1 ] = mat * ( rectCoords[ 1 ] - P );
	coords[ 2 ] = mat * ( rectCoords[ 2 ] - P );
	coords[ 3 ] = mat * ( rectCoords[ 3 ] - P );
	coords[ 0 ] = normalize( coords[ 0 ] );
	coords[ 1 ] = normalize( coords[ 1 ] );
	coords[ 2 ] = normalize( coords[ 2 ] );
	coords[ 3 ] = normalize( coords[ 3 ] );
	vec3 vectorFormFactor = vec3( 0.0 );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 0 ], coords[ 1 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 1 ], coords[ 2 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 2 ], coords[ 3 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 3 ], coords[ 0 ] );
	float result = LTC_ClippedSphereFormFactor( vectorFormFactor );
	return vec3( result );
}
#if defined( USE_SHEEN )
float D_Charlie( float roughness, float dotNH ) {
	float alpha = pow2( roughness );
	float invAlpha = 1.0 / alpha;
	float cos2h = dotNH * dotNH;
	float sin2h = max( 1.0 - cos2h, 0.0078125 );
	return ( 2.0 + invAlpha ) * pow( sin2h, invAlpha * 0.5 ) / ( 2.0 * PI );
}
float V_Neubelt( float dotNV, float dotNL ) {
	return saturate( 1.0 / ( 4.0 * ( dotNL + dotNV - dotNL * dotNV ) ) );
}
vec3 BRDF_Sheen( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, vec3 sheenColor, const in float sheenRoughness ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float D = D_Charlie( sheenRoughness, dotNH );
	float V = V_Neubelt( dotNV, dotNL );
	return sheenColor * ( D * V );
}
#endif
float IBLSheenBRDF( const in vec3 normal, const in vec3 viewDir, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	float r2 = roughness * roughness;
	float rInv = 1.0 / ( roughness + 0.1 );
	float a = -1.9362 + 1.0678 * roughness + 0.4573 * r2 - 0.8469 * rInv;
	float b = -0.6014 + 0.5538 * roughness - 0.4670 * r2 - 0.1255 * rInv;
	float DG = exp( a * dotNV + b );
	return saturate( DG );
}
vec3 EnvironmentBRDF( const in vec3 normal, const in vec3 viewDir, const in vec3 specularColor, const in float specularF90, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	vec2 fab = texture2D( dfgLUT, vec2( roughness, dotNV ) ).rg;
	return specularColor * fab.x + specularF90 * fab.y;
}
#ifdef USE_IRIDESCENCE
void computeMultiscatteringIridescence( const in vec2 fab, const in vec3 specularColor, const in float specularF90, const in float iridescence, const in vec3 iridescenceF0, inout vec3 singleScatter, inout vec3 multiScatter ) {
#else
void computeMultiscattering( const in vec2 fab, const in vec3 specularColor, const in float specularF90, inout vec3 singleScatter, inout vec3 multiScatter ) {
#endif
	#ifdef USE_IRIDESCENCE
		vec3 Fr = mix( specularColor, iridescenceF0, iridescence );
	#else
		vec3 Fr = specularColor;
	#endif
	vec3 FssEss = Fr * fab.x + specularF90 * fab.y;
	float Ess = fab.x + fab.y;
	float Ems = 1.0 - Ess;
	vec3 Favg = Fr + ( 1.0 - Fr ) * 0.047619;	vec3 Fms = FssEss * Favg / ( 1.0 - Ems * Favg );
	singleScatter += FssEss;
	multiScatter += Fms * Ems;
}
#if NUM_RECT_AREA_LIGHTS > 0
	void RE_Direct_RectArea_Physical( const in RectAreaLight rectAreaLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
		vec3 normal = geometryNormal;
		vec3 viewDir = geometryViewDir;
		vec3 position = geometryPosition;
		vec3 lightPos = rectAreaLight.position;
		vec3 halfWidth = rectAreaLight.halfWidth;
		vec3 halfHeight = rectAreaLight.halfHeight;
		vec3 lightColor = rectAreaLight.color;
		float roughness = material.roughness;
		vec3 rectCoords[ 4 ];
		rectCoords[ 0 ] = lightPos + halfWidth - halfHeight;		rectCoords[ 1 ] = lightPos - halfWidth - halfHeight;
		rectCoords[ 2 ] = lightPos - halfWidth + halfHeight;
		rectCoords[ 3 ] = lightPos + halfWidth + halfHeight;
		vec2 uv = LTC_Uv( normal, viewDir, roughness );
		vec4 t1 = texture2D( ltc_1, uv );
		vec4 t2 = texture2D( ltc_2, uv );
		mat3 mInv = mat3(
			vec3( t1.x, 0, t1.y ),
			vec3(    0, 1,    0 ),
			vec3( t1.z, 0, t1.w )
		);
		vec3 fresnel = ( material.specularColorBlended * t2.x + ( material.specularF90 - material.specularColorBlended ) * t2.y );
		reflectedLight.directSpecular += lightColor * fresnel * LTC_Evaluate( normal, viewDir, position, mInv, rectCoords );
		reflectedLight.directDiffuse += lightColor * material.diffuseContribution * LTC_Evaluate( normal, viewDir, position, mat3( 1.0 ), rectCoords );
		#ifdef USE_CLEARCOAT
			vec3 Ncc = geometryClearcoatNormal;
			vec2 uvClearcoat = LTC_Uv( Ncc, viewDir, material.clearcoatRoughness );
			vec4 t1Clearcoat = texture2D( ltc_1, uvClearcoat );
			vec4 t2Clearcoat = texture2D( ltc_2, uvClearcoat );
			mat3 mInvClearcoat = mat3(
				vec3( t1Clearcoat.x, 0, t1Clearcoat.y ),
				vec3(             0, 1,             0 ),
				vec3( t1Clearcoat.z, 0, t1Clearcoat.w )
			);
			vec3 fresnelClearcoat = material.clearcoatF0 * t2Clearcoat.x + ( material.clearcoatF90 - material.clearcoatF0 ) * t2Clearcoat.y;
			clearcoatSpecularDirect += lightColor * fresnelClearcoat * LTC_Evaluate( Ncc, viewDir, position, mInvClearcoat, rectCoords );
		#endif
	}
#endif
void RE_Direct_Physical( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	#ifdef USE_CLEARCOAT
		float dotNLcc = saturate( dot( geometryClearcoatNormal, directLight.direction ) );
		vec3 ccIrradiance = dotNLcc * directLight.color;
		clearcoatSpecularDirect += ccIrradiance * BRDF_GGX_Clearcoat( directLight.direction, geometryViewDir, geometryClearcoatNormal, material );
	#endif
	#ifdef USE_SHEEN
 
 		sheenSpecularDirect += irradiance * BRDF_Sheen( directLight.direction, geometryViewDir, geometryNormal, material.sheenColor, material.sheenRoughness );
 
 		float sheenAlbedoV = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
 		float sheenAlbedoL = IBLSheenBRDF( geometryNormal, directLight.direction, material.sheenRoughness );
 
 		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * max( sheenAlbedoV, sheenAlbedoL );
 
 		irradiance *= sheenEnergyComp;
 
 	#endif
	vec3 specularBRDF = BRDF_GGX( directLight.direction, geometryViewDir, geometryNormal, material );
	#ifdef USE_RETROREFLECTION
		vec3 retroViewDir = reflect( - geometryViewDir, geometryNormal );
		vec3 retroSpecularBRDF = BRDF_GGX( directLight.direction, retroViewDir, geometryNormal, material );
		specularBRDF = mix( specularBRDF, retroSpecularBRDF, saturate( material.retroreflectivity ) );
	#endif
	reflectedLight.directSpecular += irradiance * specularBRDF * material.multiScatteringCompensation;
	vec3 halfDir = normalize( directLight.direction + geometryViewDir );
	float dotVH = saturate( dot( geometryViewDir, halfDir ) );
	vec3 F = F_Schlick( material.specularColor, material.specularF90, dotVH );
	#ifdef USE_RETROREFLECTION
		vec3 retroHalfDir = normalize( directLight.direction + retroViewDir );
		float dotRetroVH = saturate( dot( retroViewDir, retroHalfDir ) );
		vec3 retroF = F_Schlick( material.specularColor, material.specularF90, dotRetroVH );
		F = mix( F, retroF, saturate( material.retroreflectivity ) );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		vec3 diffuseBRDF = BRDF_EON( directLight.direction, geometryViewDir, geometryNormal, material.diffuseColor, material.diffuseRoughness ) * ( 1.0 - material.metalness );
	#else
		vec3 diffuseBRDF = BRDF_Lambert( material.diffuseContribution );
	#endif
	reflectedLight.directDiffuse += irradiance * diffuseBRDF * ( 1.0 - F );
}
void RE_IndirectDiffuse_Physical( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 singleScattering = vec3( 0.0 );
	vec3 multiScattering = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScattering, multiScattering );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScattering, multiScattering );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuseAlbedo = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness );
		vec3 diffuse = irradiance * RECIPROCAL_PI * diffuseAlbedo * ( 1.0 - singleScattering - multiScattering );
	#else
		vec3 diffuse = irradiance * BRDF_Lambert( material.diffuseContribution ) * ( 1.0 - singleScattering - multiScattering );
	#endif
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		sheenSpecularIndirect += irradiance * material.sheenColor * sheenAlbedo * RECIPROCAL_PI;
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		diffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectDiffuse += diffuse;
}
void RE_IndirectSpecular_Physical( const in vec3 radiance, const in vec3 irradiance, const in vec3 clearcoatRadiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
	#ifdef USE_CLEARCOAT
		clearcoatSpecularIndirect += clearcoatRadiance * EnvironmentBRDF( geometryClearcoatNormal, geometryViewDir, material.clearcoatF0, material.clearcoatF90, material.clearcoatRoughness );
	#endif
	#ifdef USE_SHEEN
		sheenSpecularIndirect += irradiance * material.sheenColor * IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness ) * RECIPROCAL_PI;
 	#endif
	vec3 singleScatteringDielectric = vec3( 0.0 );
	vec3 multiScatteringDielectric = vec3( 0.0 );
	vec3 singleScatteringMetallic = vec3( 0.0 );
	vec3 multiScatteringMetallic = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscatteringIridescence( material.dfg, material.diffuseColor, material.specularF90, material.iridescence, material.iridescenceF0Metallic, singleScatteringMetallic, multiScatteringMetallic );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscattering( material.dfg, material.diffuseColor, material.specularF90, singleScatteringMetallic, multiScatteringMetallic );
	#endif
	vec3 singleScattering = mix( singleScatteringDielectric, singleScatteringMetallic, material.metalness );
	vec3 multiScattering = mix( multiScatteringDielectric, multiScatteringMetallic, material.metalness );
	vec3 totalScatteringDielectric = singleScatteringDielectric + multiScatteringDielectric;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuse = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness ) * ( 1.0 - totalScatteringDielectric );
	#else
		vec3 diffuse = material.diffuseContribution * ( 1.0 - totalScatteringDielectric );
	#endif
	vec3 cosineWeightedIrradiance = irradiance * RECIPROCAL_PI;
	vec3 indirectSpecular = radiance * singleScattering;
	indirectSpecular += multiScattering * cosineWeightedIrradiance;
	vec3 indirectDiffuse = diffuse * cosineWeightedIrradiance;
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		indirectSpecular *= sheenEnergyComp;
		indirectDiffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectSpecular += indirectSpecular;
	reflectedLight.indirectDiffuse += indirectDiffuse;
}
#define RE_Direct				RE_Direct_Physical
#define RE_Direct_RectArea		RE_Direct_RectArea_Physical
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Physical
#define RE_IndirectSpecular		RE_IndirectSpecular_Physical
float computeSpecularOcclusion( const in float dotNV, const in float ambientOcclusion, const in float roughness ) {
	return saturate( pow( dotNV + ambientOcclusion, exp2( - 16.0 * roughness - 1.0 ) ) - 1.0 + ambientOcclusion );
}`,hM=`
vec3 geometryPosition = - vViewPosition;
vec3 geometryNormal = normal;
vec3 geometryViewDir = ( isOrthographic ) ? vec3( 0, 0, 1 ) : normalize( vViewPosition );
vec3 geometryClearcoatNormal = vec3( 0.0 );
#ifdef USE_CLEARCOAT
	geometryClearcoatNormal = clearcoatNormal;
#endif
#ifdef USE_IRIDESCENCE
	float dotNVi = saturate( dot( normal, geometryViewDir ) );
	if ( material.iridescenceThickness == 0.0 ) {
		material.iridescence = 0.0;
	} else {
		material.iridescence = saturate( material.iridescence );
	}
	if ( material.iridescence > 0.0 ) {
		vec3 iridescenceFresnelDielectric = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.specularColor );
		vec3 iridescenceFresnelMetallic = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.diffuseColor );
		material.iridescenceFresnel = mix( iridescenceFresnelDielectric, iridescenceFresnelMetallic, material.metalness );
		material.iridescenceF0Dielectric = Schlick_to_F0( iridescenceFresnelDielectric, 1.0, dotNVi );
		material.iridescenceF0Metallic = Schlick_to_F0( iridescenceFresnelMetallic, 1.0, dotNVi );
	}
#endif
#ifdef STANDARD
	float dotNVms = saturate( dot( geometryNormal, geometryViewDir ) );
	material.dfg = texture2D( dfgLUT, vec2( material.roughness, dotNVms ) ).rg;
	#if ( NUM_SUN_LIGHTS > 0 || NUM_DIR_LIGHTS > 0 || NUM_POINT_LIGHTS > 0 || NUM_SPOT_LIGHTS > 0 )
		float EssMs = material.dfg.x + material.dfg.y;
		material.multiScatteringCompensation = 1.0 + material.specularColorBlended * ( 1.0 / EssMs - 1.0 );
	#endif
#endif
IncidentLight directLight;
#if ( NUM_POINT_LIGHTS > 0 ) && defined( RE_Direct )
	PointLight pointLight;
	#if defined( USE_SHADOWMAP ) && NUM_POINT_LIGHT_SHADOWS > 0
	PointLightShadow pointLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHTS; i ++ ) {
		pointLight = pointLights[ i ];
		getPointLightInfo( pointLight, geometryPosition, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_POINT_LIGHT_SHADOWS ) && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
		pointLightShadow = pointLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getPointShadow( pointShadowMap[ i ], pointLightShadow.shadowMapSize, pointLightShadow.shadowIntensity, pointLightShadow.shadowBias, pointLightShadow.shadowRadius, vPointShadowCoord[ i ], pointLightShadow.shadowCameraNear, pointLightShadow.shadowCameraFar ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SPOT_LIGHTS > 0 ) && defined( RE_Direct )
	SpotLight spotLight;
	vec4 spotColor;
	vec3 spotLightCoord;
	bool inSpotLightMap;
	#if defined( USE_SHADOWMAP ) && NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHTS; i ++ ) {
		spotLight = spotLights[ i ];
		getSpotLightInfo( spotLight, geometryPosition, directLight );
		#if ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#define SPOT_LIGHT_MAP_INDEX UNROLLED_LOOP_INDEX
		#elif ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		#define SPOT_LIGHT_MAP_INDEX NUM_SPOT_LIGHT_MAPS
		#else
		#define SPOT_LIGHT_MAP_INDEX ( UNROLLED_LOOP_INDEX - NUM_SPOT_LIGHT_SHADOWS + NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#endif
		#if ( SPOT_LIGHT_MAP_INDEX < NUM_SPOT_LIGHT_MAPS )
			spotLightCoord = vSpotLightCoord[ i ].xyz / vSpotLightCoord[ i ].w;
			inSpotLightMap = all( lessThan( abs( spotLightCoord * 2. - 1. ), vec3( 1.0 ) ) );
			spotColor = texture2D( spotLightMap[ SPOT_LIGHT_MAP_INDEX ], spotLightCoord.xy );
			directLight.color = inSpotLightMap ? directLight.color * spotColor.rgb : directLight.color;
		#endif
		#undef SPOT_LIGHT_MAP_INDEX
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		spotLightShadow = spotLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( spotShadowMap[ i ], spotLightShadow.shadowMapSize, spotLightShadow.shadowIntensity, spotLightShadow.shadowBias, spotLightShadow.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SUN_LIGHTS > 0 ) && defined( RE_Direct )
	SunLight sunLight;
	#if defined( USE_SHADOWMAP ) && NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHTS; i ++ ) {
		sunLight = sunLights[ i ];
		getSunLightInfo( sunLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SUN_LIGHT_SHADOWS )
		sunLightShadow = sunLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getSunShadow( sunShadowMap[ i ], sunLightShadow, UNROLLED_LOOP_INDEX ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_DIR_LIGHTS > 0 ) && defined( RE_Direct )
	DirectionalLight directionalLight;
	#if defined( USE_SHADOWMAP ) && NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHTS; i ++ ) {
		directionalLight = directionalLights[ i ];
		getDirectionalLightInfo( directionalLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_DIR_LIGHT_SHADOWS )
		directionalLightShadow = directionalLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( directionalShadowMap[ i ], directionalLightShadow.shadowMapSize, directionalLightShadow.shadowIntensity, directionalLightShadow.shadowBias, directionalLightShadow.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_RECT_AREA_LIGHTS > 0 ) && defined( RE_Direct_RectArea )
	RectAreaLight rectAreaLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_RECT_AREA_LIGHTS; i ++ ) {
		rectAreaLight = rectAreaLights[ i ];
		RE_Direct_RectArea( rectAreaLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if defined( RE_IndirectDiffuse )
	vec3 iblIrradiance = vec3( 0.0 );
	vec3 irradiance = getAmbientLightIrradiance( ambientLightColor );
	#if defined( USE_LIGHT_PROBES )
		irradiance += getLightProbeIrradiance( lightProbe, geometryNormal );
	#endif
	#if ( NUM_HEMI_LIGHTS > 0 )
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_HEMI_LIGHTS; i ++ ) {
			irradiance += getHemisphereLightIrradiance( hemisphereLights[ i ], geometryNormal );
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_LIGHT_PROBE_GRIDS > 0
		vec3 probeWorldPos = ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz;
		vec3 probeWorldNormal = transformNormalByInverseViewMatrix( geometryNormal, viewMatrix );
		int probeGrid = - 1;
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( isInsideLightProbeGrid( probeWorldPos, probeWorldNormal, probesMin[ i ], probesMax[ i ], probesResolution[ i ] ) ) probeGrid = UNROLLED_LOOP_INDEX;
		}
		#pragma unroll_loop_end
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( probeGrid == UNROLLED_LOOP_INDEX ) irradiance += getLightProbeGridIrradiance( probesSH[ i ], probesMin[ i ], probesMax[ i ], probesResolution[ i ], probeWorldPos, probeWorldNormal );
		}
		#pragma unroll_loop_end
	#endif
#endif
#if defined( RE_IndirectSpecular )
	vec3 radiance = vec3( 0.0 );
	vec3 clearcoatRadiance = vec3( 0.0 );
#endif`,uM=`#if defined( RE_IndirectDiffuse )
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		vec3 lightMapIrradiance = lightMapTexel.rgb * lightMapIntensity;
		irradiance += lightMapIrradiance;
	#endif
	#if defined( USE_ENVMAP ) && defined( ENVMAP_TYPE_PMREM )
		#if defined( STANDARD ) || defined( LAMBERT ) || defined( PHONG )
			iblIrradiance += getIBLIrradiance( geometryNormal );
		#endif
	#endif
#endif
#if defined( USE_ENVMAP ) && defined( RE_IndirectSpecular )
	#ifdef USE_ANISOTROPY
		vec3 iblRadiance = getIBLAnisotropyRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
	#else
		vec3 iblRadiance = getIBLRadiance( geometryViewDir, geometryNormal, material.roughness );
	#endif
	#ifdef USE_RETROREFLECTION
		#ifdef USE_ANISOTROPY
			vec3 retroIBLRadiance = getIBLAnisotropyRetroRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
		#else
			vec3 retroIBLRadiance = getIBLRetroRadiance( geometryViewDir, geometryNormal, material.roughness );
		#endif
		iblRadiance = mix( iblRadiance, retroIBLRadiance, saturate( material.retroreflectivity ) );
	#endif
	radiance += iblRadiance;
	#ifdef USE_CLEARCOAT
		clearcoatRadiance += getIBLRadiance( geometryViewDir, geometryClearcoatNormal, material.clearcoatRoughness );
	#endif
#endif`,fM=`#if defined( RE_IndirectDiffuse )
	#if defined( LAMBERT ) || defined( PHONG )
		irradiance += iblIrradiance;
	#endif
	RE_IndirectDiffuse( irradiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif
#if defined( RE_IndirectSpecular )
	RE_IndirectSpecular( radiance, iblIrradiance, clearcoatRadiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif`,dM=`#if NUM_LIGHT_PROBE_GRIDS > 0
uniform highp sampler3D probesSH[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMin[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMax[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesResolution[ NUM_LIGHT_PROBE_GRIDS ];
bool isInsideLightProbeGrid( vec3 worldPos, vec3 worldNormal, vec3 probesMin, vec3 probesMax, vec3 probesResolution ) {
	vec3 spacing = ( probesMax - probesMin ) / probesResolution;
	vec3 samplePos = worldPos + worldNormal * spacing * 0.5;
	vec3 margin = spacing * 0.01;
	return all( greaterThanEqual( samplePos, probesMin - margin ) ) && all( lessThanEqual( samplePos, probesMax + margin ) );
}
vec3 getLightProbeGridIrradiance( highp sampler3D probesSH, vec3 probesMin, vec3 probesMax, vec3 probesResolution, vec3 worldPos, vec3 worldNormal ) {
	vec3 res = probesResolution;
	vec3 gridRange = probesMax - probesMin;
	vec3 probeSpacing = gridRange / res;
	vec3 samplePos = worldPos + worldNormal * probeSpacing * 0.5;
	vec3 uvw = clamp( ( samplePos - probesMin ) / gridRange, 0.5 / res, 1.0 - 0.5 / res );
	float nz          = res.z;
	float paddedSlices = nz + 2.0;
	float atlasDepth  = 7.0 * paddedSlices;
	float uvZBase     = uvw.z * nz + 1.0;
	vec4 s0 = texture( probesSH, vec3( uvw.xy, ( uvZBase                       ) / atlasDepth ) );
	vec4 s1 = texture( probesSH, vec3( uvw.xy, ( uvZBase +       paddedSlices   ) / atlasDepth ) );
	vec4 s2 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 2.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s3 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 3.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s4 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 4.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s5 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 5.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s6 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 6.0 * paddedSlices   ) / atlasDepth ) );
	vec3 c0 = s0.xyz;
	vec3 c1 = vec3( s0.w, s1.xy );
	vec3 c2 = vec3( s1.zw, s2.x );
	vec3 c3 = s2.yzw;
	vec3 c4 = s3.xyz;
	vec3 c5 = vec3( s3.w, s4.xy );
	vec3 c6 = vec3( s4.zw, s5.x );
	vec3 c7 = s5.yzw;
	vec3 c8 = s6.xyz;
	float x = worldNormal.x, y = worldNormal.y, z = worldNormal.z;
	vec3 result = c0 * 0.886227;
	result += c1 * 2.0 * 0.511664 * y;
	result += c2 * 2.0 * 0.511664 * z;
	result += c3 * 2.0 * 0.511664 * x;
	result += c4 * 2.0 * 0.429043 * x * y;
	result += c5 * 2.0 * 0.429043 * y * z;
	result += c6 * ( 0.743125 * z * z - 0.247708 );
	result += c7 * 2.0 * 0.429043 * x * z;
	result += c8 * 0.429043 * ( x * x - y * y );
	return max( result, vec3( 0.0 ) );
}
#endif`,pM=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	gl_FragDepth = vIsPerspective == 0.0 ? gl_FragCoord.z : log2( vFragDepth ) * logDepthBufFC * 0.5;
#endif`,mM=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	uniform float logDepthBufFC;
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,gM=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,xM=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	vFragDepth = 1.0 + gl_Position.w;
	vIsPerspective = float( isPerspectiveMatrix( projectionMatrix ) );
#endif`,_M=`#ifdef USE_MAP
	vec4 sampledDiffuseColor = texture2D( map, vMapUv );
	#ifdef DECODE_VIDEO_TEXTURE
		sampledDiffuseColor = sRGBTransferEOTF( sampledDiffuseColor );
	#endif
	diffuseColor *= sampledDiffuseColor;
#endif`,vM=`#ifdef USE_MAP
	uniform sampler2D map;
#endif`,yM=`#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
	#if defined( USE_POINTS_UV )
		vec2 uv = vUv;
	#else
		vec2 uv = ( uvTransform * vec3( gl_PointCoord.x, 1.0 - gl_PointCoord.y, 1 ) ).xy;
	#endif
#endif
#ifdef USE_MAP
	diffuseColor *= texture2D( map, uv );
#endif
#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, uv ).g;
#endif`,bM=`#if defined( USE_POINTS_UV )
	varying vec2 vUv;
#else
	#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
		uniform mat3 uvTransform;
	#endif
#endif
#ifdef USE_MAP
	uniform sampler2D map;
#endif
#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,SM=`float metalnessFactor = metalness;
#ifdef USE_METALNESSMAP
	vec4 texelMetalness = texture2D( metalnessMap, vMetalnessMapUv );
	metalnessFactor *= texelMetalness.b;
#endif`,MM=`#ifdef USE_METALNESSMAP
	uniform sampler2D metalnessMap;
#endif`,wM=`#ifdef USE_INSTANCING_MORPH
	float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	float morphTargetBaseInfluence = texelFetch( morphTexture, ivec2( 0, gl_InstanceID ), 0 ).r;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		morphTargetInfluences[i] =  texelFetch( morphTexture, ivec2( i + 1, gl_InstanceID ), 0 ).r;
	}
#endif`,EM=`#if defined( USE_MORPHCOLORS )
	#if defined( USE_COLOR_ALPHA )
		vColor *= morphTargetBaseInfluence;
	#elif defined( USE_COLOR )
		vColor.rgb *= morphTargetBaseInfluence;
	#endif
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		#if defined( USE_COLOR_ALPHA )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor += getMorph( gl_VertexID, i, 2 ) * morphTargetInfluences[ i ];
		#elif defined( USE_COLOR )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor.rgb += getMorph( gl_VertexID, i, 2 ).rgb * morphTargetInfluences[ i ];
		#endif
	}
#endif`,TM=`#ifdef USE_MORPHNORMALS
	objectNormal *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) objectNormal += getMorph( gl_VertexID, i, 1 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,AM=`#ifdef USE_MORPHTARGETS
	#ifndef USE_INSTANCING_MORPH
		uniform float morphTargetBaseInfluence;
		uniform float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	#endif
	uniform sampler2DArray morphTargetsTexture;
	uniform ivec2 morphTargetsTextureSize;
	vec4 getMorph( const in int vertexIndex, const in int morphTargetIndex, const in int offset ) {
		int texelIndex = vertexIndex * MORPHTARGETS_TEXTURE_STRIDE + offset;
		int y = texelIndex / morphTargetsTextureSize.x;
		int x = texelIndex - y * morphTargetsTextureSize.x;
		ivec3 morphUV = ivec3( x, y, morphTargetIndex );
		return texelFetch( morphTargetsTexture, morphUV, 0 );
	}
#endif`,RM=`#ifdef USE_MORPHTARGETS
	transformed *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) transformed += getMorph( gl_VertexID, i, 0 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,CM=`float faceDirection = gl_FrontFacing ? 1.0 : - 1.0;
#ifdef FLAT_SHADED
	vec3 fdx = dFdx( vViewPosition );
	vec3 fdy = dFdy( vViewPosition );
	vec3 normal = normalize( cross( fdx, fdy ) );
#else
	vec3 normal = normalize( vNormal );
	#ifdef DOUBLE_SIDED
		normal *= faceDirection;
	#endif
#endif
#if defined( USE_NORMALMAP_TANGENTSPACE ) || defined( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY )
	#ifdef USE_TANGENT
		mat3 tbn = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn = getTangentFrame( - vViewPosition, normal,
		#if defined( USE_NORMALMAP )
			vNormalMapUv
		#elif defined( USE_CLEARCOAT_NORMALMAP )
			vClearcoatNormalMapUv
		#else
			vUv
		#endif
		);
	#endif
	#ifdef DOUBLE_SIDED
		tbn[0] *= faceDirection;
		tbn[1] *= faceDirection;
	#endif
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	#ifdef USE_TANGENT
		mat3 tbn2 = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn2 = getTangentFrame( - vViewPosition, normal, vClearcoatNormalMapUv );
	#endif
	#ifdef DOUBLE_SIDED
		tbn2[0] *= faceDirection;
		tbn2[1] *= faceDirection;
	#endif
#endif
vec3 nonPerturbedNormal = normal;`,PM=`#ifdef USE_NORMALMAP_OBJECTSPACE
	normal = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#ifdef FLIP_SIDED
		normal = - normal;
	#endif
	#ifdef DOUBLE_SIDED
		normal = normal * faceDirection;
	#endif
	normal = normalize( normalMatrix * normal );
#elif defined( USE_NORMALMAP_TANGENTSPACE )
	vec3 mapN = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#if defined( USE_PACKED_NORMALMAP )
		mapN = vec3( mapN.xy, sqrt( saturate( 1.0 - dot( mapN.xy, mapN.xy ) ) ) );
	#endif
	mapN.xy *= normalScale;
	normal = normalize( tbn * mapN );
#elif defined( USE_BUMPMAP )
	normal = perturbNormalArb( - vViewPosition, normal, dHdxy_fwd(), faceDirection );
#endif`,IM=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,LM=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,NM=`#ifndef FLAT_SHADED
	vNormal = normalize( transformedNormal );
	#ifdef USE_TANGENT
		vTangent = normalize( transformedTangent );
		vBitangent = normalize( cross( vNormal, vTangent ) * tangent.w );
		#ifdef FLIP_SIDED
			vBitangent = - vBitangent;
		#endif
	#endif
#endif`,DM=`#ifdef USE_NORMALMAP
	uniform sampler2D normalMap;
	uniform vec2 normalScale;
#endif
#ifdef USE_NORMALMAP_OBJECTSPACE
	uniform mat3 normalMatrix;
#endif
#if ! defined ( USE_TANGENT ) && ( defined ( USE_NORMALMAP_TANGENTSPACE ) || defined ( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY ) )
	mat3 getTangentFrame( vec3 eye_pos, vec3 surf_norm, vec2 uv ) {
		vec3 q0 = dFdx( eye_pos.xyz );
		vec3 q1 = dFdy( eye_pos.xyz );
		vec2 st0 = dFdx( uv.st );
		vec2 st1 = dFdy( uv.st );
		vec3 N = surf_norm;
		vec3 q1perp = cross( q1, N );
		vec3 q0perp = cross( N, q0 );
		vec3 T = q1perp * st0.x + q0perp * st1.x;
		vec3 B = q1perp * st0.y + q0perp * st1.y;
		float det = max( dot( T, T ), dot( B, B ) );
		float scale = ( det == 0.0 ) ? 0.0 : inversesqrt( det );
		return mat3( T * scale, B * scale, N );
	}
#endif`,UM=`#ifdef USE_CLEARCOAT
	vec3 clearcoatNormal = nonPerturbedNormal;
#endif`,FM=`#ifdef USE_CLEARCOAT_NORMALMAP
	vec3 clearcoatMapN = texture2D( clearcoatNormalMap, vClearcoatNormalMapUv ).xyz * 2.0 - 1.0;
	clearcoatMapN.xy *= clearcoatNormalScale;
	clearcoatNormal = normalize( tbn2 * clearcoatMapN );
#endif`,OM=`#ifdef USE_CLEARCOATMAP
	uniform sampler2D clearcoatMap;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform sampler2D clearcoatNormalMap;
	uniform vec2 clearcoatNormalScale;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform sampler2D clearcoatRoughnessMap;
#endif`,BM=`#ifdef USE_IRIDESCENCEMAP
	uniform sampler2D iridescenceMap;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform sampler2D iridescenceThicknessMap;
#endif`,kM=`#ifdef OPAQUE
diffuseColor.a = 1.0;
#endif
#ifdef USE_TRANSMISSION
diffuseColor.a *= material.transmissionAlpha;
#endif
gl_FragColor = vec4( outgoingLight, diffuseColor.a );`,zM=`vec3 packNormalToRGB( const in vec3 normal ) {
	return normalize( normal ) * 0.5 + 0.5;
}
vec3 unpackRGBToNormal( const in vec3 rgb ) {
	return 2.0 * rgb.xyz - 1.0;
}
const float PackUpscale = 256. / 255.;const float UnpackDownscale = 255. / 256.;const float ShiftRight8 = 1. / 256.;
const float Inv255 = 1. / 255.;
const vec4 PackFactors = vec4( 1.0, 256.0, 256.0 * 256.0, 256.0 * 256.0 * 256.0 );
const vec2 UnpackFactors2 = vec2( UnpackDownscale, 1.0 / PackFactors.g );
const vec3 UnpackFactors3 = vec3( UnpackDownscale / PackFactors.rg, 1.0 / PackFactors.b );
const vec4 UnpackFactors4 = vec4( UnpackDownscale / PackFactors.rgb, 1.0 / PackFactors.a );
vec4 packDepthToRGBA( const in float v ) {
	if( v <= 0.0 )
		return vec4( 0., 0., 0., 0. );
	if( v >= 1.0 )
		return vec4( 1., 1., 1., 1. );
	float vuf;
	float af = modf( v * PackFactors.a, vuf );
	float bf = modf( vuf * ShiftRight8, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec4( vuf * Inv255, gf * PackUpscale, bf * PackUpscale, af );
}
vec3 packDepthToRGB( const in float v ) {
	if( v <= 0.0 )
		return vec3( 0., 0., 0. );
	if( v >= 1.0 )
		return vec3( 1., 1., 1. );
	float vuf;
	float bf = modf( v * PackFactors.b, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec3( vuf * Inv255, gf * PackUpscale, bf );
}
vec2 packDepthToRG( const in float v ) {
	if( v <= 0.0 )
		return vec2( 0., 0. );
	if( v >= 1.0 )
		return vec2( 1., 1. );
	float vuf;
	float gf = modf( v * 256., vuf );
	return vec2( vuf * Inv255, gf );
}
float unpackRGBAToDepth( const in vec4 v ) {
	return dot( v, UnpackFactors4 );
}
float unpackRGBToDepth( const in vec3 v ) {
	return dot( v, UnpackFactors3 );
}
float unpackRGToDepth( const in vec2 v ) {
	return v.r * UnpackFactors2.r + v.g * UnpackFactors2.g;
}
vec4 pack2HalfToRGBA( const in vec2 v ) {
	vec4 r = vec4( v.x, fract( v.x * 255.0 ), v.y, fract( v.y * 255.0 ) );
	return vec4( r.x - r.y / 255.0, r.y, r.z - r.w / 255.0, r.w );
}
vec2 unpackRGBATo2Half( const in vec4 v ) {
	return vec2( v.x + ( v.y / 255.0 ), v.z + ( v.w / 255.0 ) );
}
float viewZToOrthographicDepth( const in float viewZ, const in float near, const in float far ) {
	return ( viewZ + near ) / ( near - far );
}
float orthographicDepthToViewZ( const in float depth, const in float near, const in float far ) {
	#ifdef USE_REVERSED_DEPTH_BUFFER
	
		return depth * ( far - near ) - far;
	#else
		return depth * ( near - far ) - near;
	#endif
}
float viewZToPerspectiveDepth( const in float viewZ, const in float near, const in float far ) {
	return ( ( near + viewZ ) * far ) / ( ( far - near ) * viewZ );
}
float perspectiveDepthToViewZ( const in float depth, const in float near, const in float far ) {
	
	#ifdef USE_REVERSED_DEPTH_BUFFER
		return ( near * far ) / ( ( near - far ) * depth - near );
	#else
		return ( near * far ) / ( ( far - near ) * depth - far );
	#endif
}`,VM=`#ifdef PREMULTIPLIED_ALPHA
	gl_FragColor.rgb *= gl_FragColor.a;
#endif`,HM=`vec4 mvPosition = vec4( transformed, 1.0 );
#ifdef USE_BATCHING
	mvPosition = batchingMatrix * mvPosition;
#endif
#ifdef USE_INSTANCING
	mvPosition = instanceMatrix * mvPosition;
#endif
mvPosition = modelViewMatrix * mvPosition;
gl_Position = projectionMatrix * mvPosition;`,GM=`#ifdef DITHERING
	gl_FragColor.rgb = dithering( gl_FragColor.rgb );
#endif`,WM=`#ifdef DITHERING
	vec3 dithering( vec3 color ) {
		float grid_position = rand( gl_FragCoord.xy );
		vec3 dither_shift_RGB = vec3( 0.25 / 255.0, -0.25 / 255.0, 0.25 / 255.0 );
		dither_shift_RGB = mix( 2.0 * dither_shift_RGB, -2.0 * dither_shift_RGB, grid_position );
		return color + dither_shift_RGB;
	}
#endif`,XM=`float roughnessFactor = roughness;
#ifdef USE_ROUGHNESSMAP
	vec4 texelRoughness = texture2D( roughnessMap, vRoughnessMapUv );
	roughnessFactor *= texelRoughness.g;
#endif`,qM=`#ifdef USE_ROUGHNESSMAP
	uniform sampler2D roughnessMap;
#endif`,$M=`#if NUM_SPOT_LIGHT_COORDS > 0
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#if NUM_SPOT_LIGHT_MAPS > 0
	uniform sampler2D spotLightMap[ NUM_SPOT_LIGHT_MAPS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		#define SUN_LIGHT_CASCADES 2
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#else
			uniform sampler2D sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#endif
		uniform mat4 sunShadowMatrix[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		uniform vec4 sunShadowCascade[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
		struct SunLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SunLightShadow sunLightShadows[ NUM_SUN_LIGHT_SHADOWS ];
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#else
			uniform sampler2D directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#endif
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#else
			uniform sampler2D spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#endif
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform samplerCubeShadow pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#elif defined( SHADOWMAP_TYPE_BASIC )
			uniform samplerCube pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#endif
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float interleavedGradientNoise( vec2 position ) {
			return fract( 52.9829189 * fract( dot( position, vec2( 0.06711056, 0.00583715 ) ) ) );
		}
		vec2 vogelDiskSample( int sampleIndex, int samplesCount, float phi ) {
			const float goldenAngle = 2.399963229728653;
			float r = sqrt( ( float( sampleIndex ) + 0.5 ) / float( samplesCount ) );
			float theta = float( sampleIndex ) * goldenAngle + phi;
			return vec2( cos( theta ), sin( theta ) ) * r;
		}
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float getShadow( sampler2DShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 texelSize = vec2( 1.0 ) / shadowMapSize;
				vec2 radius = shadowRadius * texelSize;
				float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
				shadow = (
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 0, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 1, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 2, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 3, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 4, 5, phi ) * radius, shadowCoord.z ) )
				) * 0.2;
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#elif defined( SHADOWMAP_TYPE_VSM )
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 distribution = texture2D( shadowMap, shadowCoord.xy ).rg;
				float mean = distribution.x;
				float variance = distribution.y * distribution.y;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					float hard_shadow = step( mean, shadowCoord.z );
				#else
					float hard_shadow = step( shadowCoord.z, mean );
				#endif
				
				if ( hard_shadow == 1.0 ) {
					shadow = 1.0;
				} else {
					variance = max( variance, 0.0000001 );
					float d = shadowCoord.z - mean;
					float p_max = variance / ( variance + d * d );
					p_max = clamp( ( p_max - 0.3 ) / 0.65, 0.0, 1.0 );
					shadow = max( hard_shadow, p_max );
				}
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#else
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				float depth = texture2D( shadowMap, shadowCoord.xy ).r;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					shadow = step( depth, shadowCoord.z );
				#else
					shadow = step( shadowCoord.z, depth );
				#endif
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#endif
	#if NUM_SUN_LIGHT_SHADOWS > 0
		float getSunShadow(
			#if defined( SHADOWMAP_TYPE_PCF )
				sampler2DShadow shadowMap,
			#else
				sampler2D shadowMap,
			#endif
			SunLightShadow sunLightShadow,
			int shadowIndex
		) {
			vec4 shadowWorldPosition = vec4( vSunShadowWorldPosition.xyz + vSunShadowWorldNormal * sunLightShadow.shadowNormalBias, 1.0 );
			float viewDepth = vSunShadowWorldPosition.w;
			int cascadeOffset = shadowIndex * SUN_LIGHT_CASCADES;
			float shadow = 1.0;
			for ( int i = SUN_LIGHT_CASCADES - 1; i >= 0; i -- ) {
				vec4 cascade = sunShadowCascade[ cascadeOffset + i ];
				if ( viewDepth >= cascade.x && viewDepth < cascade.y ) {
					float cascadeShadow = getShadow(
						shadowMap,
						sunLightShadow.shadowMapSize,
						sunLightShadow.shadowIntensity,
						sunLightShadow.shadowBias,
						sunLightShadow.shadowRadius,
						sunShadowMatrix[ cascadeOffset + i ] * shadowWorldPosition
					);
					shadow = mix( cascadeShadow, shadow, smoothstep( cascade.z, cascade.y, viewDepth ) );
				}
			}
			return shadow;
		}
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
	#if defined( SHADOWMAP_TYPE_PCF )
	float getPointShadow( samplerCubeShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 bd3D = normalize( lightToPosition );
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float lightDistance = length( lightToPosition );
			float depthRange = shadowCameraFar - shadowCameraNear;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				float depthA = - shadowCameraNear / depthRange - shadowBias;
				float depthB = shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#else
				float depthA = shadowCameraFar / depthRange + shadowBias;
				float depthB = - shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#endif
			float texelSize = shadowRadius / shadowMapSize.x;
			vec3 absDir = abs( bd3D );
			vec3 tangent = absDir.x > absDir.z ? vec3( 0.0, 1.0, 0.0 ) : vec3( 1.0, 0.0, 0.0 );
			tangent = normalize( cross( bd3D, tangent ) );
			vec3 bitangent = cross( bd3D, tangent );
			float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
			shadow = 0.0;
			for ( int i = 0; i < 5; i ++ ) {
				vec2 offset = vogelDiskSample( i, 5, phi );
				vec3 direction = bd3D + ( tangent * offset.x + bitangent * offset.y ) * texelSize;
				vec3 absDirection = abs( direction );
				float dp = depthA + depthB / max( max( absDirection.x, absDirection.y ), absDirection.z );
				shadow += texture( shadowMap, vec4( direction, dp ) );
			}
			shadow *= 0.2;
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#elif defined( SHADOWMAP_TYPE_BASIC )
	float getPointShadow( samplerCube shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float dp = ( shadowCameraFar * ( viewSpaceZ - shadowCameraNear ) ) / ( viewSpaceZ * ( shadowCameraFar - shadowCameraNear ) );
			dp += shadowBias;
			vec3 bd3D = normalize( lightToPosition );
			float depth = textureCube( shadowMap, bd3D ).r;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				depth = 1.0 - depth;
			#endif
			shadow = step( dp, depth );
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#endif
	#endif
#endif`,YM=`#if NUM_SPOT_LIGHT_COORDS > 0
	uniform mat4 spotLightMatrix[ NUM_SPOT_LIGHT_COORDS ];
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		uniform mat4 directionalShadowMatrix[ NUM_DIR_LIGHT_SHADOWS ];
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		uniform mat4 pointShadowMatrix[ NUM_POINT_LIGHT_SHADOWS ];
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
#endif`,ZM=`#if ( defined( USE_SHADOWMAP ) && ( NUM_DIR_LIGHT_SHADOWS > 0 || NUM_SUN_LIGHT_SHADOWS > 0 || NUM_POINT_LIGHT_SHADOWS > 0 ) ) || ( NUM_SPOT_LIGHT_COORDS > 0 )
	#ifdef HAS_NORMAL
		vec3 shadowWorldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
	#else
		vec3 shadowWorldNormal = vec3( 0.0 );
	#endif
	vec4 shadowWorldPosition;
#endif
#if defined( USE_SHADOWMAP )
	#if NUM_SUN_LIGHT_SHADOWS > 0
		vSunShadowWorldPosition = vec4( worldPosition.xyz, - mvPosition.z );
		vSunShadowWorldNormal = shadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * directionalLightShadows[ i ].shadowNormalBias, 0 );
			vDirectionalShadowCoord[ i ] = directionalShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * pointLightShadows[ i ].shadowNormalBias, 0 );
			vPointShadowCoord[ i ] = pointShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
#endif
#if NUM_SPOT_LIGHT_COORDS > 0
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_COORDS; i ++ ) {
		shadowWorldPosition = worldPosition;
		#if ( defined( USE_SHADOWMAP ) && UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
			shadowWorldPosition.xyz += shadowWorldNormal * spotLightShadows[ i ].shadowNormalBias;
		#endif
		vSpotLightCoord[ i ] = spotLightMatrix[ i ] * shadowWorldPosition;
	}
	#pragma unroll_loop_end
#endif`,JM=`float getShadowMask() {
	float shadow = 1.0;
	#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHT_SHADOWS; i ++ ) {
		sunLight = sunLightShadows[ i ];
		shadow *= receiveShadow ? getSunShadow( sunShadowMap[ i ], sunLight, UNROLLED_LOOP_INDEX ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
		directionalLight = directionalLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( directionalShadowMap[ i ], directionalLight.shadowMapSize, directionalLight.shadowIntensity, directionalLight.shadowBias, directionalLight.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_SHADOWS; i ++ ) {
		spotLight = spotLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( spotShadowMap[ i ], spotLight.shadowMapSize, spotLight.shadowIntensity, spotLight.shadowBias, spotLight.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0 && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
	PointLightShadow pointLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
		pointLight = pointLightShadows[ i ];
		shadow *= receiveShadow ? getPointShadow( pointShadowMap[ i ], pointLight.shadowMapSize, pointLight.shadowIntensity, pointLight.shadowBias, pointLight.shadowRadius, vPointShadowCoord[ i ], pointLight.shadowCameraNear, pointLight.shadowCameraFar ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#endif
	return shadow;
}`,KM=`#ifdef USE_SKINNING
	mat4 boneMatX = getBoneMatrix( skinIndex.x );
	mat4 boneMatY = getBoneMatrix( skinIndex.y );
	mat4 boneMatZ = getBoneMatrix( skinIndex.z );
	mat4 boneMatW = getBoneMatrix( skinIndex.w );
#endif`,jM=`#ifdef USE_SKINNING
	uniform mat4 bindMatrix;
	uniform mat4 bindMatrixInverse;
	uniform highp sampler2D boneTexture;
	mat4 getBoneMatrix( const in float i ) {
		int size = textureSize( boneTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( boneTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( boneTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( boneTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( boneTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
#endif`,QM=`#ifdef USE_SKINNING
	vec4 skinVertex = bindMatrix * vec4( transformed, 1.0 );
	vec4 skinned = vec4( 0.0 );
	skinned += boneMatX * skinVertex * skinWeight.x;
	skinned += boneMatY * skinVertex * skinWeight.y;
	skinned += boneMatZ * skinVertex * skinWeight.z;
	skinned += boneMatW * skinVertex * skinWeight.w;
	transformed = ( bindMatrixInverse * skinned ).xyz;
#endif`,t1=`#ifdef USE_SKINNING
	mat4 skinMatrix = mat4( 0.0 );
	skinMatrix += skinWeight.x * boneMatX;
	skinMatrix += skinWeight.y * boneMatY;
	skinMatrix += skinWeight.z * boneMatZ;
	skinMatrix += skinWeight.w * boneMatW;
	skinMatrix = bindMatrixInverse * skinMatrix * bindMatrix;
	objectNormal = vec4( skinMatrix * vec4( objectNormal, 0.0 ) ).xyz;
	#ifdef USE_TANGENT
		objectTangent = vec4( skinMatrix * vec4( objectTangent, 0.0 ) ).xyz;
	#endif
#endif`,e1=`float specularStrength;
#ifdef USE_SPECULARMAP
	vec4 texelSpecular = texture2D( specularMap, vSpecularMapUv );
	specularStrength = texelSpecular.r;
#else
	specularStrength = 1.0;
#endif`,n1=`#ifdef USE_SPECULARMAP
	uniform sampler2D specularMap;
#endif`,i1=`#if defined( TONE_MAPPING )
	gl_FragColor.rgb = toneMapping( gl_FragColor.rgb );
#endif`,s1=`#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
uniform float toneMappingExposure;
vec3 LinearToneMapping( vec3 color ) {
	return saturate( toneMappingExposure * color );
}
vec3 ReinhardToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	return saturate( color / ( vec3( 1.0 ) + color ) );
}
vec3 CineonToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	color = max( vec3( 0.0 ), color - 0.004 );
	return pow( ( color * ( 6.2 * color + 0.5 ) ) / ( color * ( 6.2 * color + 1.7 ) + 0.06 ), vec3( 2.2 ) );
}
vec3 RRTAndODTFit( vec3 v ) {
	vec3 a = v * ( v + 0.0245786 ) - 0.000090537;
	vec3 b = v * ( 0.983729 * v + 0.4329510 ) + 0.238081;
	return a / b;
}
vec3 ACESFilmicToneMapping( vec3 color ) {
	const mat3 ACESInputMat = mat3(
		vec3( 0.59719, 0.07600, 0.02840 ),		vec3( 0.35458, 0.90834, 0.13383 ),
		vec3( 0.04823, 0.01566, 0.83777 )
	);
	const mat3 ACESOutputMat = mat3(
		vec3(  1.60475, -0.10208, -0.00327 ),		vec3( -0.53108,  1.10813, -0.07276 ),
		vec3( -0.07367, -0.00605,  1.07602 )
	);
	color *= toneMappingExposure / 0.6;
	color = ACESInputMat * color;
	color = RRTAndODTFit( color );
	color = ACESOutputMat * color;
	return saturate( color );
}
const mat3 LINEAR_REC2020_TO_LINEAR_SRGB = mat3(
	vec3( 1.6605, - 0.1246, - 0.0182 ),
	vec3( - 0.5876, 1.1329, - 0.1006 ),
	vec3( - 0.0728, - 0.0083, 1.1187 )
);
const mat3 LINEAR_SRGB_TO_LINEAR_REC2020 = mat3(
	vec3( 0.6274, 0.0691, 0.0164 ),
	vec3( 0.3293, 0.9195, 0.0880 ),
	vec3( 0.0433, 0.0113, 0.8956 )
);
vec3 agxDefaultContrastApprox( vec3 x ) {
	vec3 x2 = x * x;
	vec3 x4 = x2 * x2;
	return + 15.5 * x4 * x2
		- 40.14 * x4 * x
		+ 31.96 * x4
		- 6.868 * x2 * x
		+ 0.4298 * x2
		+ 0.1191 * x
		- 0.00232;
}
vec3 AgXToneMapping( vec3 color ) {
	const mat3 AgXInsetMatrix = mat3(
		vec3( 0.856627153315983, 0.137318972929847, 0.11189821299995 ),
		vec3( 0.0951212405381588, 0.761241990602591, 0.0767994186031903 ),
		vec3( 0.0482516061458583, 0.101439036467562, 0.811302368396859 )
	);
	const mat3 AgXOutsetMatrix = mat3(
		vec3( 1.1271005818144368, - 0.1413297634984383, - 0.14132976349843826 ),
		vec3( - 0.11060664309660323, 1.157823702216272, - 0.11060664309660294 ),
		vec3( - 0.016493938717834573, - 0.016493938717834257, 1.2519364065950405 )
	);
	const float AgxMinEv = - 12.47393;	const float AgxMaxEv = 4.026069;
	color *= toneMappingExposure;
	color = LINEAR_SRGB_TO_LINEAR_REC2020 * color;
	color = AgXInsetMatrix * color;
	color = max( color, 1e-10 );	color = log2( color );
	color = ( color - AgxMinEv ) / ( AgxMaxEv - AgxMinEv );
	color = clamp( color, 0.0, 1.0 );
	color = agxDefaultContrastApprox( color );
	color = AgXOutsetMatrix * color;
	color = pow( max( vec3( 0.0 ), color ), vec3( 2.2 ) );
	color = LINEAR_REC2020_TO_LINEAR_SRGB * color;
	color = clamp( color, 0.0, 1.0 );
	return color;
}
vec3 NeutralToneMapping( vec3 color ) {
	const float StartCompression = 0.8 - 0.04;
	const float Desaturation = 0.15;
	color *= toneMappingExposure;
	float x = min( color.r, min( color.g, color.b ) );
	float offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
	color -= offset;
	float peak = max( color.r, max( color.g, color.b ) );
	if ( peak < StartCompression ) return color;
	float d = 1. - StartCompression;
	float newPeak = 1. - d * d / ( peak + d - StartCompression );
	color *= newPeak / peak;
	float g = 1. - 1. / ( Desaturation * ( peak - newPeak ) + 1. );
	return mix( color, vec3( newPeak ), g );
}
vec3 CustomToneMapping( vec3 color ) { return color; }`,r1=`#ifdef USE_TRANSMISSION
	material.transmission = transmission;
	material.transmissionAlpha = 1.0;
	material.thickness = thickness;
	material.attenuationDistance = attenuationDistance;
	material.attenuationColor = attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		material.transmission *= texture2D( transmissionMap, vTransmissionMapUv ).r;
	#endif
	#ifdef USE_THICKNESSMAP
		material.thickness *= texture2D( thicknessMap, vThicknessMapUv ).g;
	#endif
	vec3 pos = vWorldPosition;
	vec3 v = normalize( cameraPosition - pos );
	vec3 n = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec4 transmitted = getIBLVolumeRefraction(
		n, v, material.roughness, material.diffuseContribution, material.specularColorBlended, material.specularF90,
		pos, modelMatrix, viewMatrix, projectionMatrix, material.dispersion, material.ior, material.thickness,
		material.attenuationColor, material.attenuationDistance );
	material.transmissionAlpha = mix( material.transmissionAlpha, transmitted.a, material.transmission );
	totalDiffuse = mix( totalDiffuse, transmitted.rgb, material.transmission );
#endif`,o1=`#ifdef USE_TRANSMISSION
	uniform float transmission;
	uniform float thickness;
	uniform float attenuationDistance;
	uniform vec3 attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		uniform sampler2D transmissionMap;
	#endif
	#ifdef USE_THICKNESSMAP
		uniform sampler2D thicknessMap;
	#endif
	uniform vec2 transmissionSamplerSize;
	uniform sampler2D transmissionSamplerMap;
	uniform mat4 modelMatrix;
	uniform mat4 projectionMatrix;
	varying vec3 vWorldPosition;
	float w0( float a ) {
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - a + 3.0 ) - 3.0 ) + 1.0 );
	}
	float w1( float a ) {
		return ( 1.0 / 6.0 ) * ( a *  a * ( 3.0 * a - 6.0 ) + 4.0 );
	}
	float w2( float a ){
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - 3.0 * a + 3.0 ) + 3.0 ) + 1.0 );
	}
	float w3( float a ) {
		return ( 1.0 / 6.0 ) * ( a * a * a );
	}
	float g0( float a ) {
		return w0( a ) + w1( a );
	}
	float g1( float a ) {
		return w2( a ) + w3( a );
	}
	float h0( float a ) {
		return - 1.0 + w1( a ) / ( w0( a ) + w1( a ) );
	}
	float h1( float a ) {
		return 1.0 + w3( a ) / ( w2( a ) + w3( a ) );
	}
	vec4 bicubic( sampler2D tex, vec2 uv, vec4 texelSize, float lod ) {
		uv = uv * texelSize.zw + 0.5;
		vec2 iuv = floor( uv );
		vec2 fuv = fract( uv );
		float g0x = g0( fuv.x );
		float g1x = g1( fuv.x );
		float h0x = h0( fuv.x );
		float h1x = h1( fuv.x );
		float h0y = h0( fuv.y );
		float h1y = h1( fuv.y );
		vec2 p0 = ( vec2( iuv.x + h0x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p1 = ( vec2( iuv.x + h1x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p2 = ( vec2( iuv.x + h0x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		vec2 p3 = ( vec2( iuv.x + h1x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		return g0( fuv.y ) * ( g0x * textureLod( tex, p0, lod ) + g1x * textureLod( tex, p1, lod ) ) +
			g1( fuv.y ) * ( g0x * textureLod( tex, p2, lod ) + g1x * textureLod( tex, p3, lod ) );
	}
	vec4 textureBicubic( sampler2D sampler, vec2 uv, float lod ) {
		vec2 fLodSize = vec2( textureSize( sampler, int( lod ) ) );
		vec2 cLodSize = vec2( textureSize( sampler, int( lod + 1.0 ) ) );
		vec2 fLodSizeInv = 1.0 / fLodSize;
		vec2 cLodSizeInv = 1.0 / cLodSize;
		vec4 fSample = bicubic( sampler, uv, vec4( fLodSizeInv, fLodSize ), floor( lod ) );
		vec4 cSample = bicubic( sampler, uv, vec4( cLodSizeInv, cLodSize ), ceil( lod ) );
		return mix( fSample, cSample, fract( lod ) );
	}
	vec3 getVolumeTransmissionRay( const in vec3 n, const in vec3 v, const in float thickness, const in float ior, const in mat4 modelMatrix ) {
		vec3 refractionVector = refract( - v, normalize( n ), 1.0 / ior );
		vec3 modelScale;
		modelScale.x = length( vec3( modelMatrix[ 0 ].xyz ) );
		modelScale.y = length( vec3( modelMatrix[ 1 ].xyz ) );
		modelScale.z = length( vec3( modelMatrix[ 2 ].xyz ) );
		return normalize( refractionVector ) * thickness * modelScale;
	}
	float applyIorToRoughness( const in float roughness, const in float ior ) {
		return roughness * clamp( ior * 2.0 - 2.0, 0.0, 1.0 );
	}
	vec4 getTransmissionSample( const in vec2 fragCoord, const in float roughness, const in float ior ) {
		float lod = log2( transmissionSamplerSize.x ) * applyIorToRoughness( roughness, ior );
		return textureBicubic( transmissionSamplerMap, fragCoord.xy, lod );
	}
	vec3 volumeAttenuation( const in float transmissionDistance, const in vec3 attenuationColor, const in float attenuationDistance ) {
		if ( isinf( attenuationDistance ) ) {
			return vec3( 1.0 );
		} else {
			vec3 attenuationCoefficient = -log( attenuationColor ) / attenuationDistance;
			vec3 transmittance = exp( - attenuationCoefficient * transmissionDistance );			return transmittance;
		}
	}
	vec4 getIBLVolumeRefraction( const in vec3 n, const in vec3 v, const in float roughness, const in vec3 diffuseColor,
		const in vec3 specularColor, const in float specularF90, const in vec3 position, const in mat4 modelMatrix,
		const in mat4 viewMatrix, const in mat4 projMatrix, const in float dispersion, const in float ior, const in float thickness,
		const in vec3 attenuationColor, const in float attenuationDistance ) {
		vec4 transmittedLight;
		vec3 transmittance;
		#ifdef USE_DISPERSION
			float halfSpread = ( ior - 1.0 ) * 0.025 * dispersion;
			vec3 iors = vec3( ior - halfSpread, ior, ior + halfSpread );
			for ( int i = 0; i < 3; i ++ ) {
				vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, iors[ i ], modelMatrix );
				vec3 refractedRayExit = position + transmissionRay;
				vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
				vec2 refractionCoords = ndcPos.xy / ndcPos.w;
				refractionCoords += 1.0;
				refractionCoords /= 2.0;
				vec4 transmissionSample = getTransmissionSample( refractionCoords, roughness, iors[ i ] );
				transmittedLight[ i ] = transmissionSample[ i ];
				transmittedLight.a += transmissionSample.a;
				transmittance[ i ] = diffuseColor[ i ] * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance )[ i ];
			}
			transmittedLight.a /= 3.0;
		#else
			vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, ior, modelMatrix );
			vec3 refractedRayExit = position + transmissionRay;
			vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
			vec2 refractionCoords = ndcPos.xy / ndcPos.w;
			refractionCoords += 1.0;
			refractionCoords /= 2.0;
			transmittedLight = getTransmissionSample( refractionCoords, roughness, ior );
			transmittance = diffuseColor * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance );
		#endif
		vec3 attenuatedColor = transmittance * transmittedLight.rgb;
		vec3 F = EnvironmentBRDF( n, v, specularColor, specularF90, roughness );
		float transmittanceFactor = ( transmittance.r + transmittance.g + transmittance.b ) / 3.0;
		return vec4( ( 1.0 - F ) * attenuatedColor, 1.0 - ( 1.0 - transmittedLight.a ) * transmittanceFactor );
	}
#endif`,a1=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_SPECULARMAP
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,l1=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	uniform mat3 mapTransform;
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	uniform mat3 alphaMapTransform;
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	uniform mat3 lightMapTransform;
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	uniform mat3 aoMapTransform;
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	uniform mat3 bumpMapTransform;
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	uniform mat3 normalMapTransform;
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_DISPLACEMENTMAP
	uniform mat3 displacementMapTransform;
	varying vec2 vDisplacementMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	uniform mat3 emissiveMapTransform;
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	uniform mat3 metalnessMapTransform;
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	uniform mat3 roughnessMapTransform;
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	uniform mat3 diffuseRoughnessMapTransform;
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	uniform mat3 anisotropyMapTransform;
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	uniform mat3 clearcoatMapTransform;
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform mat3 clearcoatNormalMapTransform;
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform mat3 clearcoatRoughnessMapTransform;
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	uniform mat3 sheenColorMapTransform;
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	uniform mat3 sheenRoughnessMapTransform;
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	uniform mat3 iridescenceMapTransform;
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform mat3 iridescenceThicknessMapTransform;
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SPECULARMAP
	uniform mat3 specularMapTransform;
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	uniform mat3 specularColorMapTransform;
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	uniform mat3 specularIntensityMapTransform;
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,c1=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	vUv = vec3( uv, 1 ).xy;
#endif
#ifdef USE_MAP
	vMapUv = ( mapTransform * vec3( MAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ALPHAMAP
	vAlphaMapUv = ( alphaMapTransform * vec3( ALPHAMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_LIGHTMAP
	vLightMapUv = ( lightMapTransform * vec3( LIGHTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_AOMAP
	vAoMapUv = ( aoMapTransform * vec3( AOMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_BUMPMAP
	vBumpMapUv = ( bumpMapTransform * vec3( BUMPMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_NORMALMAP
	vNormalMapUv = ( normalMapTransform * vec3( NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DISPLACEMENTMAP
	vDisplacementMapUv = ( displacementMapTransform * vec3( DISPLACEMENTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_EMISSIVEMAP
	vEmissiveMapUv = ( emissiveMapTransform * vec3( EMISSIVEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_METALNESSMAP
	vMetalnessMapUv = ( metalnessMapTransform * vec3( METALNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ROUGHNESSMAP
	vRoughnessMapUv = ( roughnessMapTransform * vec3( ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	vDiffuseRoughnessMapUv = ( diffuseRoughnessMapTransform * vec3( DIFFUSE_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ANISOTROPYMAP
	vAnisotropyMapUv = ( anisotropyMapTransform * vec3( ANISOTROPYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOATMAP
	vClearcoatMapUv = ( clearcoatMapTransform * vec3( CLEARCOATMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	vClearcoatNormalMapUv = ( clearcoatNormalMapTransform * vec3( CLEARCOAT_NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	vClearcoatRoughnessMapUv = ( clearcoatRoughnessMapTransform * vec3( CLEARCOAT_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCEMAP
	vIridescenceMapUv = ( iridescenceMapTransform * vec3( IRIDESCENCEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	vIridescenceThicknessMapUv = ( iridescenceThicknessMapTransform * vec3( IRIDESCENCE_THICKNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_COLORMAP
	vSheenColorMapUv = ( sheenColorMapTransform * vec3( SHEEN_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	vSheenRoughnessMapUv = ( sheenRoughnessMapTransform * vec3( SHEEN_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULARMAP
	vSpecularMapUv = ( specularMapTransform * vec3( SPECULARMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_COLORMAP
	vSpecularColorMapUv = ( specularColorMapTransform * vec3( SPECULAR_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	vSpecularIntensityMapUv = ( specularIntensityMapTransform * vec3( SPECULAR_INTENSITYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_TRANSMISSIONMAP
	vTransmissionMapUv = ( transmissionMapTransform * vec3( TRANSMISSIONMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_THICKNESSMAP
	vThicknessMapUv = ( thicknessMapTransform * vec3( THICKNESSMAP_UV, 1 ) ).xy;
#endif`,h1=`#if defined( USE_ENVMAP ) || defined( DISTANCE ) || defined ( USE_SHADOWMAP ) || defined ( USE_TRANSMISSION ) || NUM_SPOT_LIGHT_COORDS > 0
	vec4 worldPosition = vec4( transformed, 1.0 );
	#ifdef USE_BATCHING
		worldPosition = batchingMatrix * worldPosition;
	#endif
	#ifdef USE_INSTANCING
		worldPosition = instanceMatrix * worldPosition;
	#endif
	worldPosition = modelMatrix * worldPosition;
#endif`,u1=`varying vec2 vUv;
uniform mat3 uvTransform;
void main() {
	vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	gl_Position = vec4( position.xy, 1.0, 1.0 );
}`,f1=`uniform sampler2D t2D;
uniform float backgroundIntensity;
varying vec2 vUv;
void main() {
	vec4 texColor = texture2D( t2D, vUv );
	#ifdef DECODE_VIDEO_TEXTURE
		texColor = vec4( mix( pow( texColor.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), texColor.rgb * 0.0773993808, vec3( lessThanEqual( texColor.rgb, vec3( 0.04045 ) ) ) ), texColor.w );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,d1=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,p1=`uniform float backgroundBlurriness;
uniform float backgroundIntensity;
uniform mat3 backgroundRotation;
varying vec3 vWorldDirection;
#include <envmap_common_pars_fragment>
void main() {
	#ifdef ENVMAP_TYPE_PMREM
		vec4 texColor = textureLod( envMap, backgroundRotation * vWorldDirection, roughnessToMip( backgroundBlurriness ) );
	#else
		vec4 texColor = textureCube( envMap, backgroundRotation * vWorldDirection );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,m1=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,g1=`uniform samplerCube tCube;
uniform float tFlip;
uniform float opacity;
varying vec3 vWorldDirection;
void main() {
	vec4 texColor = textureCube( tCube, vec3( tFlip * vWorldDirection.x, vWorldDirection.yz ) );
	gl_FragColor = texColor;
	gl_FragColor.a *= opacity;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,x1=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
varying vec2 vHighPrecisionZW;
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vHighPrecisionZW = gl_Position.zw;
}`,_1=`#if DEPTH_PACKING == 3200
	uniform float opacity;
#endif
#include <common>
#include <packing>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
varying vec2 vHighPrecisionZW;
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#if DEPTH_PACKING == 3200
		diffuseColor.a = opacity;
	#endif
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <logdepthbuf_fragment>
	#ifdef USE_REVERSED_DEPTH_BUFFER
		float fragCoordZ = vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ];
	#else
		float fragCoordZ = 0.5 * vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ] + 0.5;
	#endif
	#if DEPTH_PACKING == 3200
		gl_FragColor = vec4( vec3( 1.0 - fragCoordZ ), opacity );
	#elif DEPTH_PACKING == 3201
		gl_FragColor = packDepthToRGBA( fragCoordZ );
	#elif DEPTH_PACKING == 3202
		gl_FragColor = vec4( packDepthToRGB( fragCoordZ ), 1.0 );
	#elif DEPTH_PACKING == 3203
		gl_FragColor = vec4( packDepthToRG( fragCoordZ ), 0.0, 1.0 );
	#endif
}`,v1=`#define DISTANCE
varying vec3 vWorldPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <worldpos_vertex>
	#include <clipping_planes_vertex>
	vWorldPosition = worldPosition.xyz;
}`,y1=`#define DISTANCE
uniform vec3 referencePosition;
uniform float nearDistance;
uniform float farDistance;
varying vec3 vWorldPosition;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	float dist = length( vWorldPosition - referencePosition );
	dist = ( dist - nearDistance ) / ( farDistance - nearDistance );
	dist = saturate( dist );
	gl_FragColor = vec4( dist, 0.0, 0.0, 1.0 );
}`,b1=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
}`,S1=`uniform sampler2D tEquirect;
varying vec3 vWorldDirection;
#include <common>
void main() {
	vec3 direction = normalize( vWorldDirection );
	vec2 sampleUV = equirectUv( direction );
	gl_FragColor = texture2D( tEquirect, sampleUV );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,M1=`uniform float scale;
attribute float lineDistance;
varying float vLineDistance;
#include <common>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	vLineDistance = scale * lineDistance;
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,w1=`uniform vec3 diffuse;
uniform float opacity;
uniform float dashSize;
uniform float totalSize;
varying float vLineDistance;
#include <common>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	if ( mod( vLineDistance, totalSize ) > dashSize ) {
		discard;
	}
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,E1=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#if defined ( USE_ENVMAP ) || defined ( USE_SKINNING )
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinbase_vertex>
		#include <skinnormal_vertex>
		#include <defaultnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <fog_vertex>
}`,T1=`uniform vec3 diffuse;
uniform float opacity;
#ifndef FLAT_SHADED
	varying vec3 vNormal;
#endif
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <fog_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		reflectedLight.indirectDiffuse += lightMapTexel.rgb * lightMapIntensity * RECIPROCAL_PI;
	#else
		reflectedLight.indirectDiffuse += vec3( 1.0 );
	#endif
	#include <aomap_fragment>
	reflectedLight.indirectDiffuse *= diffuseColor.rgb;
	vec3 outgoingLight = reflectedLight.indirectDiffuse;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,A1=`#define LAMBERT
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,R1=`#define LAMBERT
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_lambert_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_lambert_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,C1=`#define MATCAP
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <displacementmap_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
	vViewPosition = - mvPosition.xyz;
}`,P1=`#define MATCAP
uniform vec3 diffuse;
uniform float opacity;
uniform sampler2D matcap;
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	vec3 viewDir = normalize( vViewPosition );
	vec3 x = normalize( vec3( viewDir.z, 0.0, - viewDir.x ) );
	vec3 y = cross( viewDir, x );
	vec2 uv = vec2( dot( x, normal ), dot( y, normal ) ) * 0.495 + 0.5;
	#ifdef USE_MATCAP
		vec4 matcapColor = texture2D( matcap, uv );
	#else
		vec4 matcapColor = vec4( vec3( mix( 0.2, 0.8, uv.y ) ), 1.0 );
	#endif
	vec3 outgoingLight = diffuseColor.rgb * matcapColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,I1=`#define NORMAL
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	vViewPosition = - mvPosition.xyz;
#endif
}`,L1=`#define NORMAL
uniform float opacity;
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <uv_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 0.0, 0.0, 0.0, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	gl_FragColor = vec4( normalize( normal ) * 0.5 + 0.5, diffuseColor.a );
	#ifdef OPAQUE
		gl_FragColor.a = 1.0;
	#endif
}`,N1=`#define PHONG
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,D1=`#define PHONG
uniform vec3 diffuse;
uniform vec3 emissive;
uniform vec3 specular;
uniform float shininess;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_phong_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_phong_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + reflectedLight.directSpecular + reflectedLight.indirectSpecular + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,U1=`#define STANDARD
varying vec3 vViewPosition;
#ifdef USE_TRANSMISSION
	varying vec3 vWorldPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
#ifdef USE_TRANSMISSION
	vWorldPosition = worldPosition.xyz;
#endif
}`,F1=`#define STANDARD
#ifdef PHYSICAL
	#define IOR
	#define USE_SPECULAR
#endif
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float roughness;
uniform float metalness;
uniform float opacity;
#ifdef IOR
	uniform float ior;
#endif
#ifdef USE_SPECULAR
	uniform float specularIntensity;
	uniform vec3 specularColor;
	#ifdef USE_SPECULAR_COLORMAP
		uniform sampler2D specularColorMap;
	#endif
	#ifdef USE_SPECULAR_INTENSITYMAP
		uniform sampler2D specularIntensityMap;
	#endif
#endif
#ifdef USE_CLEARCOAT
	uniform float clearcoat;
	uniform float clearcoatRoughness;
#endif
#ifdef USE_DIFFUSE_ROUGHNESS
	uniform float diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		uniform sampler2D diffuseRoughnessMap;
	#endif
#endif
#ifdef USE_DISPERSION
	uniform float dispersion;
#endif
#ifdef USE_RETROREFLECTION
	uniform float retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	uniform float iridescence;
	uniform float iridescenceIOR;
	uniform float iridescenceThicknessMinimum;
	uniform float iridescenceThicknessMaximum;
#endif
#ifdef USE_SHEEN
	uniform vec3 sheenColor;
	uniform float sheenRoughness;
	#ifdef USE_SHEEN_COLORMAP
		uniform sampler2D sheenColorMap;
	#endif
	#ifdef USE_SHEEN_ROUGHNESSMAP
		uniform sampler2D sheenRoughnessMap;
	#endif
#endif
#ifdef USE_ANISOTROPY
	uniform vec2 anisotropyVector;
	#ifdef USE_ANISOTROPYMAP
		uniform sampler2D anisotropyMap;
	#endif
#endif
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <iridescence_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_physical_pars_fragment>
#include <transmission_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <clearcoat_pars_fragment>
#include <iridescence_pars_fragment>
#include <roughnessmap_pars_fragment>
#include <metalnessmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <roughnessmap_fragment>
	#include <metalnessmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <clearcoat_normal_fragment_begin>
	#include <clearcoat_normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_physical_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 totalDiffuse = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse;
	vec3 totalSpecular = reflectedLight.directSpecular + reflectedLight.indirectSpecular;
	#include <transmission_fragment>
	vec3 outgoingLight = totalDiffuse + totalSpecular + totalEmissiveRadiance;
	#ifdef USE_SHEEN
 
		outgoingLight = outgoingLight + sheenSpecularDirect + sheenSpecularIndirect;
 
 	#endif
	#ifdef USE_CLEARCOAT
		float dotNVcc = saturate( dot( geometryClearcoatNormal, geometryViewDir ) );
		vec3 Fcc = F_Schlick( material.clearcoatF0, material.clearcoatF90, dotNVcc );
		outgoingLight = outgoingLight * ( 1.0 - material.clearcoat * Fcc ) + ( clearcoatSpecularDirect + clearcoatSpecularIndirect ) * material.clearcoat;
	#endif
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,O1=`#define TOON
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,B1=`#define TOON
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <gradientmap_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_toon_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_toon_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,k1=`uniform float size;
uniform float scale;
#include <common>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
#ifdef USE_POINTS_UV
	varying vec2 vUv;
	uniform mat3 uvTransform;
#endif
void main() {
	#ifdef USE_POINTS_UV
		vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	#endif
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	gl_PointSize = size;
	#ifdef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) gl_PointSize *= ( scale / - mvPosition.z );
	#endif
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <fog_vertex>
}`,z1=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <color_pars_fragment>
#include <map_particle_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_particle_fragment>
	#include <color_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,V1=`#include <common>
#include <batching_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <shadowmap_pars_vertex>
void main() {
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,H1=`uniform vec3 color;
uniform float opacity;
#include <common>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <logdepthbuf_pars_fragment>
#include <shadowmap_pars_fragment>
#include <shadowmask_pars_fragment>
void main() {
	#include <logdepthbuf_fragment>
	gl_FragColor = vec4( color, opacity * ( 1.0 - getShadowMask() ) );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,G1=`uniform float rotation;
uniform vec2 center;
#include <common>
#include <uv_pars_vertex>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	vec4 mvPosition = modelViewMatrix[ 3 ];
	vec2 scale = vec2( length( modelMatrix[ 0 ].xyz ), length( modelMatrix[ 1 ].xyz ) );
	#ifndef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) scale *= - mvPosition.z;
	#endif
	vec2 alignedPosition = ( position.xy - ( center - vec2( 0.5 ) ) ) * scale;
	vec2 rotatedPosition;
	rotatedPosition.x = cos( rotation ) * alignedPosition.x - sin( rotation ) * alignedPosition.y;
	rotatedPosition.y = sin( rotation ) * alignedPosition.x + cos( rotation ) * alignedPosition.y;
	mvPosition.xy += rotatedPosition;
	gl_Position = projectionMatrix * mvPosition;
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,W1=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
}`,fe={alphahash_fragment:fS,alphahash_pars_fragment:dS,alphamap_fragment:pS,alphamap_pars_fragment:mS,alphatest_fragment:gS,alphatest_pars_fragment:xS,aomap_fragment:_S,aomap_pars_fragment:vS,batching_pars_vertex:yS,batching_vertex:bS,begin_vertex:SS,beginnormal_vertex:MS,bsdfs:wS,iridescence_fragment:ES,bumpmap_pars_fragment:TS,clipping_planes_fragment:AS,clipping_planes_pars_fragment:RS,clipping_planes_pars_vertex:CS,clipping_planes_vertex:PS,color_fragment:IS,color_pars_fragment:LS,color_pars_vertex:NS,color_vertex:DS,common:US,defaultnormal_vertex:FS,displacementmap_pars_vertex:OS,displacementmap_vertex:BS,emissivemap_fragment:kS,emissivemap_pars_fragment:zS,colorspace_fragment:VS,colorspace_pars_fragment:HS,envmap_fragment:GS,envmap_common_pars_fragment:WS,envmap_pars_fragment:XS,envmap_pars_vertex:qS,envmap_physical_pars_fragment:iM,envmap_vertex:$S,fog_vertex:YS,fog_pars_vertex:ZS,fog_fragment:JS,fog_pars_fragment:KS,gradientmap_pars_fragment:jS,lightmap_pars_fragment:QS,lights_lambert_fragment:tM,lights_lambert_pars_fragment:eM,lights_pars_begin:nM,lights_toon_fragment:sM,lights_toon_pars_fragment:rM,lights_phong_fragment:oM,lights_phong_pars_fragment:aM,lights_physical_fragment:lM,lights_physical_pars_fragment:cM,lights_fragment_begin:hM,lights_fragment_maps:uM,lights_fragment_end:fM,lightprobes_pars_fragment:dM,logdepthbuf_fragment:pM,logdepthbuf_pars_fragment:mM,logdepthbuf_pars_vertex:gM,logdepthbuf_vertex:xM,map_fragment:_M,map_pars_fragment:vM,map_particle_fragment:yM,map_particle_pars_fragment:bM,metalnessmap_fragment:SM,metalnessmap_pars_fragment:MM,morphinstance_vertex:wM,morphcolor_vertex:EM,morphnormal_vertex:TM,morphtarget_pars_vertex:AM,morphtarget_vertex:RM,normal_fragment_begin:CM,normal_fragment_maps:PM,normal_pars_fragment:IM,normal_pars_vertex:LM,normal_vertex:NM,normalmap_pars_fragment:DM,clearcoat_normal_fragment_begin:UM,clearcoat_normal_fragment_maps:FM,clearcoat_pars_fragment:OM,iridescence_pars_fragment:BM,opaque_fragment:kM,packing:zM,premultiplied_alpha_fragment:VM,project_vertex:HM,dithering_fragment:GM,dithering_pars_fragment:WM,roughnessmap_fragment:XM,roughnessmap_pars_fragment:qM,shadowmap_pars_fragment:$M,shadowmap_pars_vertex:YM,shadowmap_vertex:ZM,shadowmask_pars_fragment:JM,skinbase_vertex:KM,skinning_pars_vertex:jM,skinning_vertex:QM,skinnormal_vertex:t1,specularmap_fragment:e1,specularmap_pars_fragment:n1,tonemapping_fragment:i1,tonemapping_pars_fragment:s1,transmission_fragment:r1,transmission_pars_fragment:o1,uv_pars_fragment:a1,uv_pars_vertex:l1,uv_vertex:c1,worldpos_vertex:h1,background_vert:u1,background_frag:f1,backgroundCube_vert:d1,backgroundCube_frag:p1,cube_vert:m1,cube_frag:g1,depth_vert:x1,depth_frag:_1,distance_vert:v1,distance_frag:y1,equirect_vert:b1,equirect_frag:S1,linedashed_vert:M1,linedashed_frag:w1,meshbasic_vert:E1,meshbasic_frag:T1,meshlambert_vert:A1,meshlambert_frag:R1,meshmatcap_vert:C1,meshmatcap_frag:P1,meshnormal_vert:I1,meshnormal_frag:L1,meshphong_vert:N1,meshphong_frag:D1,meshphysical_vert:U1,meshphysical_frag:F1,meshtoon_vert:O1,meshtoon_frag:B1,points_vert:k1,points_frag:z1,shadow_vert:V1,shadow_frag:H1,sprite_vert:G1,sprite_frag:W1},Lt={common:{diffuse:{value:new Yt(16777215)},opacity:{value:1},map:{value:null},mapTransform:{value:new ie},alphaMap:{value:null},alphaMapTransform:{value:new ie},alphaTest:{value:0}},specularmap:{specularMap:{value:null},specularMapTransform:{value:new ie}},envmap:{envMap:{value:null},envMapRotation:{value:new ie},reflectivity:{value:1},ior:{value:1.5},refractionRatio:{value:.98},dfgLUT:{value:null}},aomap:{aoMap:{value:null},aoMapIntensity:{value:1},aoMapTransform:{value:new ie}},lightmap:{lightMap:{value:null},lightMapIntensity:{value:1},lightMapTransform:{value:new ie}},bumpmap:{bumpMap:{value:null},bumpMapTransform:{value:new ie},bumpScale:{value:1}},normalmap:{normalMap:{value:null},normalMapTransform:{value:new ie},normalScale:{value:new Jt(1,1)}},displacementmap:{displacementMap:{value:null},displacementMapTransform:{value:new ie},displacementScale:{value:1},displacementBias:{value:0}},emissivemap:{emissiveMap:{value:null},emissiveMapTransform:{value:new ie}},metalnessmap:{metalnessMap:{value:null},metalnessMapTransform:{value:new ie}},roughnessmap:{roughnessMap:{value:null},roughnessMapTransform:{value:new ie}},gradientmap:{gradientMap:{value:null}},fog:{fogDensity:{value:25e-5},fogNear:{value:1},fogFar:{value:2e3},fogColor:{value:new Yt(16777215)}},lights:{ambientLightColor:{value:[]},lightProbe:{value:[]},sunLights:{value:[],properties:{direction:{},color:{}}},sunLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},sunShadowMatrix:{value:[]},sunShadowCascade:{value:[]},directionalLights:{value:[],properties:{direction:{},color:{}}},directionalLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},directionalShadowMatrix:{value:[]},spotLights:{value:[],properties:{color:{},position:{},direction:{},distance:{},coneCos:{},penumbraCos:{},decay:{}}},spotLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},spotLightMap:{value:[]},spotLightMatrix:{value:[]},pointLights:{value:[],properties:{color:{},position:{},decay:{},distance:{}}},pointLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{},shadowCameraNear:{},shadowCameraFar:{}}},pointShadowMatrix:{value:[]},hemisphereLights:{value:[],properties:{direction:{},skyColor:{},groundColor:{}}},rectAreaLights:{value:[],properties:{color:{},position:{},width:{},height:{}}},ltc_1:{value:null},ltc_2:{value:null},probesSH:{value:[]},probesMin:{value:[]},probesMax:{value:[]},probesResolution:{value:[]}},points:{diffuse:{value:new Yt(16777215)},opacity:{value:1},size:{value:1},scale:{value:1},map:{value:null},alphaMap:{value:null},alphaMapTransform:{value:new ie},alphaTest:{value:0},uvTransform:{value:new ie}},sprite:{diffuse:{value:new Yt(16777215)},opacity:{value:1},center:{value:new Jt(.5,.5)},rotation:{value:0},map:{value:null},mapTransform:{value:new ie},alphaMap:{value:null},alphaMapTransform:{value:new ie},alphaTest:{value:0}}},ts={basic:{uniforms:Bn([Lt.common,Lt.specularmap,Lt.envmap,Lt.aomap,Lt.lightmap,Lt.fog]),vertexShader:fe.meshbasic_vert,fragmentShader:fe.meshbasic_frag},lambert:{uniforms:Bn([Lt.common,Lt.specularmap,Lt.envmap,Lt.aomap,Lt.lightmap,Lt.emissivemap,Lt.bumpmap,Lt.normalmap,Lt.displacementmap,Lt.fog,Lt.lights,{emissive:{value:new Yt(0)},envMapIntensity:{value:1}}]),vertexShader:fe.meshlambert_vert,fragmentShader:fe.meshlambert_frag},phong:{uniforms:Bn([Lt.common,Lt.specularmap,Lt.envmap,Lt.aomap,Lt.lightmap,Lt.emissivemap,Lt.bumpmap,Lt.normalmap,Lt.displacementmap,Lt.fog,Lt.lights,{emissive:{value:new Yt(0)},specular:{value:new Yt(1118481)},shininess:{value:30},envMapIntensity:{value:1}}]),vertexShader:fe.meshphong_vert,fragmentShader:fe.meshphong_frag},standard:{uniforms:Bn([Lt.common,Lt.envmap,Lt.aomap,Lt.lightmap,Lt.emissivemap,Lt.bumpmap,Lt.normalmap,Lt.displacementmap,Lt.roughnessmap,Lt.metalnessmap,Lt.fog,Lt.lights,{emissive:{value:new Yt(0)},roughness:{value:1},metalness:{value:0},envMapIntensity:{value:1}}]),vertexShader:fe.meshphysical_vert,fragmentShader:fe.meshphysical_frag},toon:{uniforms:Bn([Lt.common,Lt.aomap,Lt.lightmap,Lt.emissivemap,Lt.bumpmap,Lt.normalmap,Lt.displacementmap,Lt.gradientmap,Lt.fog,Lt.lights,{emissive:{value:new Yt(0)}}]),vertexShader:fe.meshtoon_vert,fragmentShader:fe.meshtoon_frag},matcap:{uniforms:Bn([Lt.common,Lt.bumpmap,Lt.normalmap,Lt.displacementmap,Lt.fog,{matcap:{value:null}}]),vertexShader:fe.meshmatcap_vert,fragmentShader:fe.meshmatcap_frag},points:{uniforms:Bn([Lt.points,Lt.fog]),vertexShader:fe.points_vert,fragmentShader:fe.points_frag},dashed:{uniforms:Bn([Lt.common,Lt.fog,{scale:{value:1},dashSize:{value:1},totalSize:{value:2}}]),vertexShader:fe.linedashed_vert,fragmentShader:fe.linedashed_frag},depth:{uniforms:Bn([Lt.common,Lt.displacementmap]),vertexShader:fe.depth_vert,fragmentShader:fe.depth_frag},normal:{uniforms:Bn([Lt.common,Lt.bumpmap,Lt.normalmap,Lt.displacementmap,{opacity:{value:1}}]),vertexShader:fe.meshnormal_vert,fragmentShader:fe.meshnormal_frag},sprite:{uniforms:Bn([Lt.sprite,Lt.fog]),vertexShader:fe.sprite_vert,fragmentShader:fe.sprite_frag},background:{uniforms:{uvTransform:{value:new ie},t2D:{value:null},backgroundIntensity:{value:1}},vertexShader:fe.background_vert,fragmentShader:fe.background_frag},backgroundCube:{uniforms:{envMap:{value:null},backgroundBlurriness:{value:0},backgroundIntensity:{value:1},backgroundRotation:{value:new ie}},vertexShader:fe.backgroundCube_vert,fragmentShader:fe.backgroundCube_frag},cube:{uniforms:{tCube:{value:null},tFlip:{value:-1},opacity:{value:1}},vertexShader:fe.cube_vert,fragmentShader:fe.cube_frag},equirect:{uniforms:{tEquirect:{value:null}},vertexShader:fe.equirect_vert,fragmentShader:fe.equirect_frag},distance:{uniforms:Bn([Lt.common,Lt.displacementmap,{referencePosition:{value:new q},nearDistance:{value:1},farDistance:{value:1e3}}]),vertexShader:fe.distance_vert,fragmentShader:fe.distance_frag},shadow:{uniforms:Bn([Lt.lights,Lt.fog,{color:{value:new Yt(0)},opacity:{value:1}}]),vertexShader:fe.shadow_vert,fragmentShader:fe.shadow_frag}};ts.physical={uniforms:Bn([ts.standard.uniforms,{clearcoat:{value:0},clearcoatMap:{value:null},clearcoatMapTransform:{value:new ie},clearcoatNormalMap:{value:null},clearcoatNormalMapTransform:{value:new ie},clearcoatNormalScale:{value:new Jt(1,1)},clearcoatRoughness:{value:0},clearcoatRoughnessMap:{value:null},clearcoatRoughnessMapTransform:{value:new ie},diffuseRoughness:{value:0},diffuseRoughnessMap:{value:null},diffuseRoughnessMapTransform:{value:new ie},dispersion:{value:0},retroreflectivity:{value:0},iridescence:{value:0},iridescenceMap:{value:null},iridescenceMapTransform:{value:new ie},iridescenceIOR:{value:1.3},iridescenceThicknessMinimum:{value:100},iridescenceThicknessMaximum:{value:400},iridescenceThicknessMap:{value:null},iridescenceThicknessMapTransform:{value:new ie},sheen:{value:0},sheenColor:{value:new Yt(0)},sheenColorMap:{value:null},sheenColorMapTransform:{value:new ie},sheenRoughness:{value:1},sheenRoughnessMap:{value:null},sheenRoughnessMapTransform:{value:new ie},transmission:{value:0},transmissionMap:{value:null},transmissionMapTransform:{value:new ie},transmissionSamplerSize:{value:new Jt},transmissionSamplerMap:{value:null},thickness:{value:0},thicknessMap:{value:null},thicknessMapTransform:{value:new ie},attenuationDistance:{value:0},attenuationColor:{value:new Yt(0)},specularColor:{value:new Yt(1,1,1)},specularColorMap:{value:null},specularColorMapTransform:{value:new ie},specularIntensity:{value:1},specularIntensityMap:{value:null},specularIntensityMapTransform:{value:new ie},anisotropyVector:{value:new Jt},anisotropyMap:{value:null},anisotropyMapTransform:{value:new ie}}]),vertexShader:fe.meshphysical_vert,fragmentShader:fe.meshphysical_frag};var _h={r:0,b:0,g:0},X1=new Ke,Z0=new ie;Z0.set(-1,0,0,0,1,0,0,0,1);function q1(i,t,e,n,s,r){let o=new Yt(0),a=s===!0?0:1,l,c,h=null,f=0,u=null;function d(y){let A=y.isScene===!0?y.background:null;if(A&&A.isTexture){let w=y.backgroundBlurriness>0;A=t.get(A,w)}return A}function g(y){let A=!1,w=d(y);w===null?m(o,a):w&&w.isColor&&(m(w,1),A=!0);let P=i.xr.getEnvironmentBlendMode();P==="additive"?e.buffers.color.setClear(0,0,0,1,r):P==="alpha-blend"&&e.buffers.color.setClear(0,0,0,0,r),(i.autoClear||A)&&(e.buffers.depth.setTest(!0),e.buffers.depth.setMask(!0),e.buffers.color.setMask(!0),i.clear(i.autoClearColor,i.autoClearDepth,i.autoClearStencil))}function M(y,A){let w=d(A);w&&w.isCubeTexture?(c===void 0&&(c=new Cn(new xo(1,1,1),new mn({name:"BackgroundCubeMaterial",uniforms:wr(ts.backgroundCube.uniforms),vertexShader:ts.backgroundCube.vertexShader,fragmentShader:ts.backgroundCube.fragmentShader,side:Kn,depthTest:!1,depthWrite:!1,fog:!1,allowOverride:!1})),c.geometry.deleteAttribute("normal"),c.geometry.deleteAttribute("uv"),c.onBeforeRender=function(P,T,_){this.matrixWorld.copyPosition(_.matrixWorld)},Object.defineProperty(c.material,"envMap",{get:function(){return this.uniforms.envMap.value}}),n.update(c)),c.material.uniforms.envMap.value=w,c.material.uniforms.backgroundBlurriness.value=A.backgroundBlurriness,c.material.uniforms.backgroundIntensity.value=A.backgroundIntensity,c.material.uniforms.backgroundRotation.value.setFromMatrix4(X1.makeRotationFromEuler(A.backgroundRotation)).transpose(),w.isRenderTargetTexture===!1&&c.material.uniforms.backgroundRotation.value.premultiply(Z0),c.material.toneMapped=ge.getTransfer(w.colorSpace)!==Re,(h!==w||f!==w.version||u!==i.toneMapping)&&(c.material.needsUpdate=!0,h=w,f=w.version,u=i.toneMapping),c.layers.enableAll(),y.unshift(c,c.geometry,c.material,0,0,null)):w&&w.isTexture&&(l===void 0&&(l=new Cn(new da(2,2),new mn({name:"BackgroundMaterial",uniforms:wr(ts.background.uniforms),vertexShader:ts.background.vertexShader,fragmentShader:ts.background.fragmentShader,side:$s,depthTest:!1,depthWrite:!1,fog:!1,allowOverride:!1})),l.geometry.deleteAttribute("normal"),Object.defineProperty(l.material,"map",{get:function(){return this.uniforms.t2D.value}}),n.update(l)),l.material.uniforms.t2D.value=w,l.material.uniforms.backgroundIntensity.value=A.backgroundIntensity,l.material.toneMapped=ge.getTransfer(w.colorSpace)!==Re,w.matrixAutoUpdate===!0&&w.updateMatrix(),l.material.uniforms.uvTransform.value.copy(w.matrix),(h!==w||f!==w.version||u!==i.toneMapping)&&(l.material.needsUpdate=!0,h=w,f=w.version,u=i.toneMapping),l.layers.enableAll(),y.unshift(l,l.geometry,l.material,0,0,null))}function m(y,A){y.getRGB(_h,rd(i)),e.buffers.color.setClear(_h.r,_h.g,_h.b,A,r)}function p(){c!==void 0&&(c.geometry.dispose(),c.material.dispose(),c=void 0),l!==void 0&&(l.geometry.dispose(),l.material.dispose(),l=void 0)}return{getClearColor:function(){return o},setClearColor:function(y,A=1){o.set(y),a=A,m(o,a)},getClearAlpha:function(){return a},setClearAlpha:function(y){a=y,m(o,a)},render:g,addToRenderList:M,dispose:p}}function $1(i,t){let e=i.getParameter(i.MAX_VERTEX_ATTRIBS),n={},s=u(null),r=s,o=!1;function a(L,H,G,N,z){let J=!1,k=f(L,N,G,H);r!==k&&(r=k,c(r.object)),J=d(L,N,G,z),J&&g(L,N,G,z),z!==null&&t.update(z,i.ELEMENT_ARRAY_BUFFER),(J||o)&&(o=!1,w(L,H,G,N),z!==null&&i.bindBuffer(i.ELEMENT_ARRAY_BUFFER,t.get(z).buffer))}function l(){return i.createVertexArray()}function c(L){return i.bindVertexArray(L)}function h(L){return i.deleteVertexArray(L)}function f(L,H,G,N){let z=N.wireframe===!0,J=n[H.id];J===void 0&&(J={},n[H.id]=J);let k=L.isInstancedMesh===!0?L.id:0,ct=J[k];ct===void 0&&(ct={},J[k]=ct);let K=ct[G.id];K===void 0&&(K={},ct[G.id]=K);let Q=K[z];return Q===void 0&&(Q=u(l()),K[z]=Q),Q}function u(L){let H=[],G=[],N=[];for(let z=0;z<e;z++)H[z]=0,G[z]=0,N[z]=0;return{geometry:null,program:null,wireframe:!1,newAttributes:H,enabledAttributes:G,attributeDivisors:N,object:L,attributes:{},index:null}}function d(L,H,G,N){let z=r.attributes,J=H.attributes,k=0,ct=G.getAttributes();for(let K in ct)if(ct[K].location>=0){let st=z[K],ft=J[K];if(ft===void 0&&(K==="instanceMatrix"&&L.instanceMatrix&&(ft=L.instanceMatrix),K==="instanceColor"&&L.instanceColor&&(ft=L.instanceColor)),st===void 0||st.attribute!==ft||ft&&st.data!==ft.data)return!0;k++}return r.attributesNum!==k||r.index!==N}function g(L,H,G,N){let z={},J=H.attributes,k=0,ct=G.getAttributes();for(let K in ct)if(ct[K].location>=0){let st=J[K];st===void 0&&(K==="instanceMatrix"&&L.instanceMatrix&&(st=L.instanceMatrix),K==="instanceColor"&&L.instanceColor&&(st=L.instanceColor));let ft={};ft.attribute=st,st&&st.data&&(ft.data=st.data),z[K]=ft,k++}r.attributes=z,r.attributesNum=k,r.index=N}function M(){let L=r.newAttributes;for(let H=0,G=L.length;H<G;H++)L[H]=0}function m(L){p(L,0)}function p(L,H){let G=r.newAttributes,N=r.enabledAttributes,z=r.attributeDivisors;G[L]=1,N[L]===0&&(i.enableVertexAttribArray(L),N[L]=1),z[L]!==H&&(i.vertexAttribDivisor(L,H),z[L]=H)}function y(){let L=r.newAttributes,H=r.enabledAttributes;for(let G=0,N=H.length;G<N;G++)H[G]!==L[G]&&(i.disableVertexAttribArray(G),H[G]=0)}function A(L,H,G,N,z,J,k){k===!0?i.vertexAttribIPointer(L,H,G,z,J):i.vertexAttribPointer(L,H,G,N,z,J)}function w(L,H,G,N){M();let z=N.attributes,J=G.getAttributes(),k=H.defaultAttributeValues;for(let ct in J){let K=J[ct];if(K.location>=0){let Q=z[ct];if(Q===void 0&&(ct==="instanceMatrix"&&L.instanceMatrix&&(Q=L.instanceMatrix),ct==="instanceColor"&&L.instanceColor&&(Q=L.instanceColor)),Q!==void 0){let st=Q.normalized,ft=Q.itemSize,ut=t.get(Q);if(ut===void 0)continue;let tt=ut.buffer,mt=ut.type,_t=ut.bytesPerElement,At=mt===i.INT||mt===i.UNSIGNED_INT||Q.gpuType===Uc;if(Q.isInterleavedBufferAttribute){let St=Q.data,Wt=St.isInterleavedBuffer===!0?St.stride:St.itemSize,oe=Q.offset;if(St.isInstancedInterleavedBuffer||St.isInstancedBufferAttribute){for(let Vt=0;Vt<K.locationSize;Vt++)p(K.location+Vt,St.meshPerAttribute);L.isInstancedMesh!==!0&&N._maxInstanceCount===void 0&&(N._maxInstanceCount=St.meshPerAttribute*St.count)}else for(let Vt=0;Vt<K.locationSize;Vt++)m(K.location+Vt);i.bindBuffer(i.ARRAY_BUFFER,tt);for(let Vt=0;Vt<K.locationSize;Vt++)A(K.location+Vt,ft/K.locationSize,mt,st,Wt*_t,(oe+ft/K.locationSize*Vt)*_t,At)}else{if(Q.isInstancedBufferAttribute){for(let St=0;St<K.locationSize;St++)p(K.location+St,Q.meshPerAttribute);L.isInstancedMesh!==!0&&N._maxInstanceCount===void 0&&(N._maxInstanceCount=Q.meshPerAttribute*Q.count)}else for(let St=0;St<K.locationSize;St++)m(K.location+St);i.bindBuffer(i.ARRAY_BUFFER,tt);for(let St=0;St<K.locationSize;St++)A(K.location+St,ft/K.locationSize,mt,st,ft*_t,ft/K.locationSize*St*_t,At)}}else if(k!==void 0){let st=k[ct];if(st!==void 0)switch(st.length){case 2:i.vertexAttrib2fv(K.location,st);break;case 3:i.vertexAttrib3fv(K.location,st);break;case 4:i.vertexAttrib4fv(K.location,st);break;default:i.vertexAttrib1fv(K.location,st)}}}}y()}function P(){V();for(let L in n){let H=n[L];for(let G in H){let N=H[G];for(let z in N){let J=N[z];for(let k in J)h(J[k].object),delete J[k];delete N[z]}}delete n[L]}}function T(L){if(n[L.id]===void 0)return;let H=n[L.id];for(let G in H){let N=H[G];for(let z in N){let J=N[z];for(let k in J)h(J[k].object),delete J[k];delete N[z]}}delete n[L.id]}function _(L){for(let H in n){let G=n[H];for(let N in G){let z=G[N];if(z[L.id]===void 0)continue;let J=z[L.id];for(let k in J)h(J[k].object),delete J[k];delete z[L.id]}}}function E(L){for(let H in n){let G=n[H],N=L.isInstancedMesh===!0?L.id:0,z=G[N];if(z!==void 0){for(let J in z){let k=z[J];for(let ct in k)h(k[ct].object),delete k[ct];delete z[J]}delete G[N],Object.keys(G).length===0&&delete n[H]}}}function V(){D(),o=!0,r!==s&&(r=s,c(r.object))}function D(){s.geometry=null,s.program=null,s.wireframe=!1}return{setup:a,reset:V,resetDefaultState:D,dispose:P,releaseStatesOfGeometry:T,releaseStatesOfObject:E,releaseStatesOfProgram:_,initAttributes:M,enableAttribute:m,disableUnusedAttributes:y}}function Y1(i,t,e){let n;function s(l){n=l}function r(l,c){i.drawArrays(n,l,c),e.update(c,n,1)}function o(l,c,h){h!==0&&(i.drawArraysInstanced(n,l,c,h),e.update(c,n,h))}function a(l,c,h){if(h===0)return;t.get("WEBGL_multi_draw").multiDrawArraysWEBGL(n,l,0,c,0,h);let u=0;for(let d=0;d<h;d++)u+=c[d];e.update(u,n,1)}this.setMode=s,this.render=r,this.renderInstances=o,this.renderMultiDraw=a}function Z1(i,t,e,n){let s;function r(){if(s!==void 0)return s;if(t.has("EXT_texture_filter_anisotropic")===!0){let _=t.get("EXT_texture_filter_anisotropic");s=i.getParameter(_.MAX_TEXTURE_MAX_ANISOTROPY_EXT)}else s=0;return s}function o(_){return!(_!==Ui&&n.convert(_)!==i.getParameter(i.IMPLEMENTATION_COLOR_READ_FORMAT))}function a(_){let E=_===Di&&(t.has("EXT_color_buffer_half_float")||t.has("EXT_color_buffer_float"));return!(_!==fi&&_!==Ni&&!E&&n.convert(_)!==i.getParameter(i.IMPLEMENTATION_COLOR_READ_TYPE))}function l(_){if(_==="highp"){if(i.getShaderPrecisionFormat(i.VERTEX_SHADER,i.HIGH_FLOAT).precision>0&&i.getShaderPrecisionFormat(i.FRAGMENT_SHADER,i.HIGH_FLOAT).precision>0)return"highp";_="mediump"}return _==="mediump"&&i.getShaderPrecisionFormat(i.VERTEX_SHADER,i.MEDIUM_FLOAT).precision>0&&i.getShaderPrecisionFormat(i.FRAGMENT_SHADER,i.MEDIUM_FLOAT).precision>0?"mediump":"lowp"}let c=e.precision!==void 0?e.precision:"highp",h=l(c);h!==c&&(jt("WebGLRenderer:",c,"not supported, using",h,"instead."),c=h);let f=e.reversedDepthBuffer===!0&&t.has("EXT_clip_control"),u=e.logarithmicDepthBuffer===!0&&f===!1;e.reversedDepthBuffer===!0&&f===!1&&jt("WebGLRenderer: Unable to use reversed depth buffer due to missing EXT_clip_control extension. Fallback to default depth buffer."),e.logarithmicDepthBuffer===!0&&f===!0&&jt("WebGLRenderer: Logarithmic depth buffer is ignored when reversed depth buffer is enabled.");let d=i.getParameter(i.MAX_TEXTURE_IMAGE_UNITS),g=i.getParameter(i.MAX_VERTEX_TEXTURE_IMAGE_UNITS),M=i.getParameter(i.MAX_TEXTURE_SIZE),m=i.getParameter(i.MAX_CUBE_MAP_TEXTURE_SIZE),p=i.getParameter(i.MAX_VERTEX_ATTRIBS),y=i.getParameter(i.MAX_VERTEX_UNIFORM_VECTORS),A=i.getParameter(i.MAX_VARYING_VECTORS),w=i.getParameter(i.MAX_FRAGMENT_UNIFORM_VECTORS),P=i.getParameter(i.MAX_SAMPLES),T=i.getParameter(i.SAMPLES);return{isWebGL2:!0,getMaxAnisotropy:r,getMaxPrecision:l,textureFormatReadable:o,textureTypeReadable:a,precision:c,logarithmicDepthBuffer:u,reversedDepthBuffer:f,maxTextures:d,maxVertexTextures:g,maxTextureSize:M,maxCubemapSize:m,maxAttributes:p,maxVertexUniforms:y,maxVaryings:A,maxFragmentUniforms:w,maxSamples:P,samples:T}}function J1(i){let t=this,e=null,n=0,s=!1,r=!1,o=new Ii,a=new ie,l={value:null,needsUpdate:!1};this.uniform=l,this.numPlanes=0,this.numIntersection=0,this.init=function(f,u){let d=f.length!==0||u||n!==0||s;return s=u,n=f.length,d},this.beginShadows=function(){r=!0,h(null)},this.endShadows=function(){r=!1},this.setGlobalState=function(f,u){e=h(f,u,0)},this.setState=function(f,u,d){let g=f.clippingPlanes,M=f.clipIntersection,m=f.clipShadows,p=i.get(f);if(!s||g===null||g.length===0||r&&!m)r?h(null):c();else{let y=r?0:n,A=y*4,w=p.clippingState||null;l.value=w,w=h(g,u,A,d);for(let P=0;P!==A;++P)w[P]=e[P];p.clippingState=w,this.numIntersection=M?this.numPlanes:0,this.numPlanes+=y}};function c(){l.value!==e&&(l.value=e,l.needsUpdate=n>0),t.numPlanes=n,t.numIntersection=0}function h(f,u,d,g){let M=f!==null?f.length:0,m=null;if(M!==0){if(m=l.value,g!==!0||m===null){let p=d+M*4,y=u.matrixWorldInverse;a.getNormalMatrix(y),(m===null||m.length<p)&&(m=new Float32Array(p));for(let A=0,w=d;A!==M;++A,w+=4)o.copy(f[A]).applyMatrix4(y,a),o.normal.toArray(m,w),m[w+3]=o.constant}l.value=m,l.needsUpdate=!0}return t.numPlanes=M,t.numIntersection=0,m}}var Ra=class extends ci{constructor(t=1,e={}){super(t,t,e),this.isWebGLCubeRenderTarget=!0;let n={width:t,height:t,depth:1},s=[n,n,n,n,n,n];this.texture=new ca(s),this._setTextureOptions(e),this.texture.isRenderTargetTexture=!0}fromEquirectangularTexture(t,e){this.texture.type=e.type,this.texture.colorSpace=e.colorSpace,this.texture.generateMipmaps=e.generateMipmaps,this.texture.minFilter=e.minFilter,this.texture.magFilter=e.magFilter;let n={uniforms:{tEquirect:{value:null}},vertexShader:`

				varying vec3 vWorldDirection;

				vec3 transformDirection( in vec3 dir, in mat4 matrix ) {

					return normalize( ( matrix * vec4( dir, 0.0 ) ).xyz );

				}

				void main() {

					vWorldDirection = transformDirection( position, modelMatrix );

					#include <begin_vertex>
					#include <project_vertex>

				}
			`,fragmentShader:`

				uniform sampler2D tEquirect;

				varying vec3 vWorldDirection;

				#include <common>

				void main() {

					vec3 direction = normalize( vWorldDirection );

					vec2 sampleUV = equirectUv( direction );

					gl_FragColor = texture2D( tEquirect, sampleUV );

				}
			`},s=new xo(5,5,5),r=new mn({name:"CubemapFromEquirect",uniforms:wr(n.uniforms),vertexShader:n.vertexShader,fragmentShader:n.fragmentShader,side:Kn,blending:vr});r.uniforms.tEquirect.value=e;let o=new Cn(s,r),a=e.minFilter;return e.minFilter===xs&&(e.minFilter=Zn),new _o(1,10,this).update(t,o),e.minFilter=a,o.geometry.dispose(),o.material.dispose(),this}clear(t,e=!0,n=!0,s=!0){let r=t.getRenderTarget();for(let o=0;o<6;o++)t.setRenderTarget(this,o),t.clear(e,n,s);t.setRenderTarget(r)}},A0=256,K1=3,j1=20,J0=256,K0=16,Q1=3,tw=new q,ew=new Yt,yh=class i{constructor(t){this._renderer=t,this._cubeSize=0,this._sourceTarget=null,this._cubeCamera=new _o(1,10,null),this._boxMesh=new Cn(new xo(5,5,5),null),this._cubemapMaterial=null,this._equirectMaterial=null,this._blurMaterial=null,this._ggxMaterial=null,this._integrationMaterial=null}fromScene(t,e=0,n=.1,s=100,r={}){let{size:o=256,position:a=tw}=r,l=this._renderer;this._setSize(o);let c=this._allocateTarget(),h=this._getSourceTarget(!0);e>0&&(h.texture.mipmapsAutoUpdate=!1);let f=l.autoClear,u=l.autoClearColor,d=l.autoClearDepth,g=l.autoClearStencil,M=t.background;l.autoClear=!0,l.autoClearColor=!0,l.autoClearDepth=!0,l.autoClearStencil=!0,M===null&&(t.background=l.getClearColor(ew));let m=new _o(n,s,h);return m.position.copy(a),m.update(l,t),l.autoClear=f,l.autoClearColor=u,l.autoClearDepth=d,l.autoClearStencil=g,t.background=M,e>0&&(h.texture.mipmapsAutoUpdate=!0,this._blur(c,e)),this._applyPMREM(c),c}fromEquirectangular(t,e=null){return this._fromTexture(t,e)}fromCubemap(t,e=null){return this._fromTexture(t,e)}compileCubemapShader(){this._cubemapMaterial===null&&(this._cubemapMaterial=P0(),this._compileMaterial(this._cubemapMaterial))}compileEquirectangularShader(){this._equirectMaterial===null&&(this._equirectMaterial=C0(),this._compileMaterial(this._equirectMaterial))}dispose(){this._sourceTarget!==null&&this._sourceTarget.dispose(),this._cubemapMaterial!==null&&this._cubemapMaterial.dispose(),this._equirectMaterial!==null&&this._equirectMaterial.dispose(),this._blurMaterial!==null&&this._blurMaterial.dispose(),this._ggxMaterial!==null&&this._ggxMaterial.dispose(),this._integrationMaterial!==null&&this._integrationMaterial.dispose(),this._boxMesh.geometry.dispose()}static lodToRoughness(t,e){return e>0?1-Math.sqrt(1-t/e):0}_setSize(t){this._cubeSize=Math.max(A0,y0(t))}_fromTexture(t,e){t.mapping===br||t.mapping===bo?this._setSize(t.image.length===0?A0:t.image[0].width||t.image[0].image.width):this._setSize(t.image.width/4);let n=e||this._allocateTarget();return this._textureToCubemap(t),this._applyPMREM(n),n}_allocateTarget(){let t=this._cubeSize,e=R0(t,!1,!1),n=Math.log2(t)-K1;for(let s=0;s<=n;s++)e.texture.mipmaps.push({width:t>>s,height:t>>s});return e.texture.name="PMREM",e.texture.isPMREMTexture=!0,e}_getSourceTarget(t=!1){let e=this._cubeSize,n=this._sourceTarget;return(n===null||n.width!==e||t&&n.depthBuffer===!1)&&(n!==null&&n.dispose(),this._sourceTarget=R0(e,!0,t)),this._sourceTarget}_compileMaterial(t){this._boxMesh.material=t,this._renderer.compile(this._boxMesh,this._cubeCamera.children[0])}_renderCube(t,e,n){let s=this._boxMesh,r=this._cubeCamera;s.material=n,r.renderTarget=t,r.activeMipmapLevel=e;let o=t.width>>e;t.viewport.set(0,0,o,o),r.update(this._renderer,s),t.viewport.set(0,0,t.width,t.height)}_textureToCubemap(t){let e;t.mapping===br||t.mapping===bo?(this._cubemapMaterial===null&&(this._cubemapMaterial=P0()),e=this._cubemapMaterial,e.uniforms.flipEnvMap.value=t.isRenderTargetTexture===!1?-1:1):(this._equirectMaterial===null&&(this._equirectMaterial=C0()),e=this._equirectMaterial),e.uniforms.envMap.value=t,this._renderCube(this._getSourceTarget(),0,e)}_applyPMREM(t){this._ggxMaterial===null&&(this._ggxMaterial=nw(),this._integrationMaterial=iw());let e=this._cubeSize,n=t.texture.mipmaps.length-1,s=this._ggxMaterial.uniforms;s.envMap.value=this._sourceTarget.texture;let r=this._integrationMaterial.uniforms;r.envMap.value=this._sourceTarget.texture,r.sourceLod.value=Math.log2(e/K0);for(let o=0;o<=n;o++){let a=i.lodToRoughness(o,n);if(o>n-Q1)r.roughness.value=a,this._renderCube(t,o,this._integrationMaterial);else{let l=a>0?Math.log2(e)+.5*Math.log2(6/(J0*Math.pow(a,4)))+.5:0;s.roughness.value=a,s.lodBias.value=l,this._renderCube(t,o,this._ggxMaterial)}}}_blur(t,e){this._blurMaterial===null&&(this._blurMaterial=sw());let n=this._blurMaterial,s=n.uniforms,r=this._sourceTarget;s.sigma.value=Math.min(e,Math.PI)/Math.SQRT2,s.envMap.value=r.texture,this._renderCube(t,0,n),s.envMap.value=t.texture,this._renderCube(r,0,n)}};function R0(i,t,e){return new Ra(i,{minFilter:xs,generateMipmaps:t,type:Di,colorSpace:dr,depthBuffer:e})}function Ca(i,t,e){return new mn({name:i,uniforms:t,vertexShader:fe.cube_vert,fragmentShader:e,side:Kn,blending:vr,depthTest:!1,depthWrite:!1})}function nw(){return Ca("PMREMGGXConvolution",{envMap:{value:null},roughness:{value:0},lodBias:{value:0}},`

		#define GGX_SAMPLES ${J0}u

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float roughness;
		uniform float lodBias;

		#include <common>

		// Van der Corput radical inverse
		float radicalInverse_VdC( uint bits ) {

			bits = ( bits << 16u ) | ( bits >> 16u );
			bits = ( ( bits & 0x55555555u ) << 1u ) | ( ( bits & 0xAAAAAAAAu ) >> 1u );
			bits = ( ( bits & 0x33333333u ) << 2u ) | ( ( bits & 0xCCCCCCCCu ) >> 2u );
			bits = ( ( bits & 0x0F0F0F0Fu ) << 4u ) | ( ( bits & 0xF0F0F0F0u ) >> 4u );
			bits = ( ( bits & 0x00FF00FFu ) << 8u ) | ( ( bits & 0xFF00FF00u ) >> 8u );
			return float( bits ) * 2.3283064365386963e-10; // / 0x100000000

		}

		// Hammersley sequence
		vec2 hammersley( uint i, uint N ) {

			return vec2( float( i ) / float( N ), radicalInverse_VdC( i ) );

		}

		void main() {

			vec3 N = normalize( vWorldDirection );

			// For very low roughness, just sample the environment directly
			if ( roughness < 0.001 ) {

				gl_FragColor = vec4( textureLod( envMap, N, 0.0 ).rgb, 1.0 );
				return;

			}

			float alpha = roughness * roughness;
			float alpha2 = alpha * alpha;

			// Tangent space basis for VNDF sampling
			vec3 up = abs( N.z ) < 0.999 ? vec3( 0.0, 0.0, 1.0 ) : vec3( 1.0, 0.0, 0.0 );
			vec3 tangent = normalize( cross( up, N ) );
			vec3 bitangent = cross( N, tangent );

			vec3 prefilteredColor = vec3( 0.0 );
			float totalWeight = 0.0;

			for ( uint i = 0u; i < GGX_SAMPLES; i ++ ) {

				vec2 Xi = hammersley( i, GGX_SAMPLES );

				// With V = N, sample the reflected direction directly.
				float invQ = 1.0 / ( 1.0 - Xi.x + alpha2 * Xi.x );
				float NdotL = ( 1.0 - Xi.x - alpha2 * Xi.x ) * invQ;

				if ( NdotL > 0.0 ) {

					float phi = 2.0 * PI * Xi.y;
					float sinTheta = 2.0 * alpha * sqrt( Xi.x * ( 1.0 - Xi.x ) ) * invQ;
					vec3 L = N * NdotL + ( tangent * cos( phi ) + bitangent * sin( phi ) ) * sinTheta;

					// Match the source mip to the sample's solid angle. The terms
					// independent of the sample are precomputed in lodBias.
					float d = alpha2 * invQ;
					float lod = max( log2( d ) + lodBias, 0.0 );

					// Weight by NdotL for the split-sum approximation
					prefilteredColor += textureLod( envMap, L, lod ).rgb * NdotL;
					totalWeight += NdotL;

				}

			}

			gl_FragColor = vec4( prefilteredColor / totalWeight, 1.0 );

		}
	`)}function iw(){return Ca("PMREMGGXIntegration",{envMap:{value:null},roughness:{value:0},sourceLod:{value:0},sourceSize:{value:K0}},`

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float roughness;
		uniform float sourceLod;
		uniform int sourceSize;

		void main() {

			vec3 N = normalize( vWorldDirection );

			float alpha = roughness * roughness;
			float alpha2 = alpha * alpha;

			float texelSize = 2.0 / float( sourceSize );

			vec3 prefilteredColor = vec3( 0.0 );
			float totalWeight = 0.0;

			// Pair opposite texels: only the one in N's hemisphere contributes.
			for ( int face = 0; face < 3; face ++ ) {

				for ( int y = 0; y < sourceSize; y ++ ) {

					for ( int x = 0; x < sourceSize; x ++ ) {

						vec2 uv = ( vec2( x, y ) + 0.5 ) * texelSize - 1.0;
						vec3 texelDirection = face == 0 ? vec3( 1.0, uv ) : ( face == 1 ? vec3( uv.x, 1.0, uv.y ) : vec3( uv, 1.0 ) );

						float invDistance = inversesqrt( 1.0 + dot( uv, uv ) );
						float NdotL = dot( N, texelDirection );
						texelDirection *= NdotL < 0.0 ? - 1.0 : 1.0;
						NdotL = abs( NdotL ) * invDistance;

						// With V = N, NdotH squared is ( 1 + NdotL ) / 2. Common factors
						// in the GGX distribution and texel solid angle cancel when normalized.
						float d = 1.0 + alpha2 + ( alpha2 - 1.0 ) * NdotL;
						float weight = NdotL * invDistance * invDistance * invDistance / ( d * d );

						prefilteredColor += textureLod( envMap, texelDirection, sourceLod ).rgb * weight;
						totalWeight += weight;

					}

				}

			}

			gl_FragColor = vec4( prefilteredColor / totalWeight, 1.0 );

		}
	`)}function sw(){return Ca("PMREMSphericalGaussianBlur",{envMap:{value:null},sigma:{value:0}},`

		#define SAMPLES ${j1}
		#define GOLDEN_ANGLE 2.39996322973

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float sigma;

		#include <common>

		void main() {

			vec3 outputDirection = normalize( vWorldDirection );

			vec3 up = abs( outputDirection.z ) < 0.999 ? vec3( 0.0, 0.0, 1.0 ) : vec3( 1.0, 0.0, 0.0 );
			vec3 tangent = normalize( cross( up, outputDirection ) );
			vec3 bitangent = cross( outputDirection, tangent );

			// Truncate the kernel at three standard deviations or at the antipode.
			float thetaMax = min( 3.0 * sigma, PI );
			float truncation = 1.0 - exp( - 0.5 * thetaMax * thetaMax / ( sigma * sigma ) );

			vec3 accumColor = vec3( 0.0 );
			float accumWeight = 0.0;

			for ( int i = 0; i < SAMPLES; i ++ ) {

				// Stratified inverse-CDF sampling of the Gaussian, placed on a golden-angle spiral.
				float stratum = ( float( i ) + 0.5 ) / float( SAMPLES );
				float theta = sigma * sqrt( - 2.0 * log( 1.0 - stratum * truncation ) );
				float phi = float( i ) * GOLDEN_ANGLE;

				vec3 offset = cos( phi ) * tangent + sin( phi ) * bitangent;
				vec3 sampleDirection = cos( theta ) * outputDirection + sin( theta ) * offset;

				// Correct the planar sample density to solid angle.
				float weight = sin( theta ) / theta;

				accumColor += weight * textureLod( envMap, sampleDirection, 0.0 ).rgb;
				accumWeight += weight;

			}

			gl_FragColor = vec4( accumColor / accumWeight, 1.0 );

		}
	`)}function C0(){return Ca("PMREMEquirectangularToCubemap",{envMap:{value:null}},`

		varying vec3 vWorldDirection;

		uniform sampler2D envMap;

		#include <common>

		void main() {

			// Average four subpixel samples to preserve small, bright features.
			vec3 direction = normalize( vWorldDirection );
			vec3 dx = dFdx( direction ) * 0.25;
			vec3 dy = dFdy( direction ) * 0.25;

			vec3 color = textureLod( envMap, equirectUv( normalize( direction - dx - dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction + dx - dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction - dx + dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction + dx + dy ) ), 0.0 ).rgb;
			gl_FragColor = vec4( color * 0.25, 1.0 );

		}
	`)}function P0(){return Ca("PMREMCubemapToCubemap",{envMap:{value:null},flipEnvMap:{value:-1}},`

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float flipEnvMap;

		void main() {

			gl_FragColor = vec4( textureCube( envMap, vec3( flipEnvMap * vWorldDirection.x, vWorldDirection.yz ) ).rgb, 1.0 );

		}
	`)}function rw(i){let t=new WeakMap,e=new WeakMap,n=null;function s(u,d=!1){return u==null?null:d?o(u):r(u)}function r(u){if(u&&u.isTexture){let d=u.mapping;if(d===Lc||d===Nc)if(t.has(u)){let g=t.get(u).texture;return a(g,u.mapping)}else{let g=u.image;if(g&&g.height>0){let M=new Ra(g.height);return M.fromEquirectangularTexture(i,u),t.set(u,M),u.addEventListener("dispose",c),a(M.texture,u.mapping)}else return null}}return u}function o(u){if(u&&u.isTexture&&u.isPMREMTexture!==!0){let d=u.mapping,g=d===Lc||d===Nc,M=d===br||d===bo;if(g||M){let m=e.get(u),p=m!==void 0?m.texture.pmremVersion:0;if(u.isRenderTargetTexture&&u.pmremVersion!==p)return n===null&&(n=new yh(i)),m=g?n.fromEquirectangular(u,m):n.fromCubemap(u,m),m.texture.pmremVersion=u.pmremVersion,e.set(u,m),m.texture;if(m!==void 0)return m.texture;{let y=u.image;return g&&y&&y.height>0||M&&y&&l(y)?(n===null&&(n=new yh(i)),m=g?n.fromEquirectangular(u):n.fromCubemap(u),m.texture.pmremVersion=u.pmremVersion,e.set(u,m),u.addEventListener("dispose",h),m.texture):null}}}return u}function a(u,d){return d===Lc?u.mapping=br:d===Nc&&(u.mapping=bo),u}function l(u){let d=0,g=6;for(let M=0;M<g;M++)u[M]!==void 0&&d++;return d===g}function c(u){let d=u.target;d.removeEventListener("dispose",c);let g=t.get(d);g!==void 0&&(t.delete(d),g.dispose())}function h(u){let d=u.target;d.removeEventListener("dispose",h);let g=e.get(d);g!==void 0&&(e.delete(d),g.dispose())}function f(){t=new WeakMap,e=new WeakMap,n!==null&&(n.dispose(),n=null)}return{get:s,dispose:f}}function ow(i){let t={};function e(n){if(t[n]!==void 0)return t[n];let s=i.getExtension(n);return t[n]=s,s}return{has:function(n){return e(n)!==null},init:function(){e("EXT_color_buffer_float"),e("WEBGL_clip_cull_distance"),e("OES_texture_float_linear"),e("EXT_color_buffer_half_float"),e("WEBGL_multisampled_render_to_texture"),e("WEBGL_render_shared_exponent")},get:function(n){let s=e(n);return s===null&&Jo("WebGLRenderer: "+n+" extension not supported."),s}}}function aw(i,t,e,n){let s={},r=new WeakMap,o=new FinalizationRegistry(g=>delete s[g]);function a(g){l(g.target)}function l(g){g.index!==null&&t.remove(g.index);for(let m in g.attributes)t.remove(g.attributes[m]);g.removeEventListener("dispose",a),delete s[g.id],o.unregister(g);let M=r.get(g);M&&(t.remove(M),r.delete(g)),n.releaseStatesOfGeometry(g),g.isInstancedBufferGeometry===!0&&delete g._maxInstanceCount,e.memory.geometries--}function c(g,M){return s[M.id]!==void 0||(M.addEventListener("dispose",a),s[M.id]=new WeakRef(M),o.register(M,M.id,M),e.memory.geometries++),M}function h(g){let M=g.attributes;for(let m in M)t.update(M[m],i.ARRAY_BUFFER)}function f(g){let M=g.index,m=g.attributes.position,p=0;if(m===void 0)return;let y=M!==null?M.array.length:m.array.length/3-1,A=m.count>=65535?oa:ra,w=new A(Math.ceil(y/3)*6,1),P=w.array;if(M!==null){let _=M.array;p=M.version;for(let E=0,V=0;E<y;E+=3){let D=_[E+0],L=_[E+1],H=_[E+2];P[V++]=D,P[V++]=L,P[V++]=L,P[V++]=H,P[V++]=H,P[V++]=D}}else{p=m.version;for(let _=0,E=0;_<y;_+=3){let V=_+0,D=_+1,L=_+2;P[E++]=V,P[E++]=D,P[E++]=D,P[E++]=L,P[E++]=L,P[E++]=V}}w.version=p;let T=r.get(g);T&&t.remove(T),r.set(g,w)}function u(g){let M=r.get(g);if(M){let m=g.index;m!==null&&M.version<m.version&&f(g)}else f(g);return r.get(g)}function d(){for(let g in s){let M=s[g].deref();M!==void 0&&l(M)}}return{get:c,update:h,getWireframeAttribute:u,dispose:d}}function lw(i,t,e){let n;function s(f){n=f}let r,o;function a(f){r=f.type,o=f.bytesPerElement}function l(f,u){i.drawElements(n,u,r,f*o),e.update(u,n,1)}function c(f,u,d){d!==0&&(i.drawElementsInstanced(n,u,r,f*o,d),e.update(u,n,d))}function h(f,u,d){if(d===0)return;t.get("WEBGL_multi_draw").multiDrawElementsWEBGL(n,u,0,r,f,0,d);let M=0;for(let m=0;m<d;m++)M+=u[m];e.update(M,n,1)}this.setMode=s,this.setIndex=a,this.render=l,this.renderInstances=c,this.renderMultiDraw=h}function cw(i){let t={geometries:0,textures:0},e={frame:0,calls:0,triangles:0,points:0,lines:0};function n(r,o,a){switch(e.calls++,o){case i.TRIANGLES:e.triangles+=a*(r/3);break;case i.LINES:e.lines+=a*(r/2);break;case i.LINE_STRIP:e.lines+=a*(r-1);break;case i.LINE_LOOP:e.lines+=a*r;break;case i.POINTS:e.points+=a*r;break;default:ne("WebGLInfo: Unknown draw mode:",o);break}}function s(){e.calls=0,e.triangles=0,e.points=0,e.lines=0}return{memory:t,render:e,programs:null,autoReset:!0,reset:s,update:n}}function hw(i,t,e){let n=new WeakMap,s=new qe;function r(o,a,l){let c=o.morphTargetInfluences,h=a.morphAttributes.position||a.morphAttributes.normal||a.morphAttributes.color,f=h!==void 0?h.length:0,u=n.get(a);if(u===void 0||u.count!==f){let V=function(){_.dispose(),n.delete(a),a.removeEventListener("dispose",V)};u!==void 0&&u.texture.dispose();let d=a.morphAttributes.position!==void 0,g=a.morphAttributes.normal!==void 0,M=a.morphAttributes.color!==void 0,m=a.morphAttributes.position||[],p=a.morphAttributes.normal||[],y=a.morphAttributes.color||[],A=0;d===!0&&(A=1),g===!0&&(A=2),M===!0&&(A=3);let w=a.attributes.position.count*A,P=1;w>t.maxTextureSize&&(P=Math.ceil(w/t.maxTextureSize),w=t.maxTextureSize);let T=new Float32Array(w*P*4*f),_=new na(T,w,P,f);_.type=Ni,_.needsUpdate=!0;let E=A*4;for(let D=0;D<f;D++){let L=m[D],H=p[D],G=y[D],N=w*P*4*D;for(let z=0;z<L.count;z++){let J=z*E;d===!0&&(s.fromBufferAttribute(L,z),T[N+J+0]=s.x,T[N+J+1]=s.y,T[N+J+2]=s.z,T[N+J+3]=0),g===!0&&(s.fromBufferAttribute(H,z),T[N+J+4]=s.x,T[N+J+5]=s.y,T[N+J+6]=s.z,T[N+J+7]=0),M===!0&&(s.fromBufferAttribute(G,z),T[N+J+8]=s.x,T[N+J+9]=s.y,T[N+J+10]=s.z,T[N+J+11]=G.itemSize===4?s.w:1)}}u={count:f,texture:_,size:new Jt(w,P)},n.set(a,u),a.addEventListener("dispose",V)}if(o.isInstancedMesh===!0&&o.morphTexture!==null)l.getUniforms().setValue(i,"morphTexture",o.morphTexture,e);else{let d=0;for(let M=0;M<c.length;M++)d+=c[M];let g=a.morphTargetsRelative?1:1-d;l.getUniforms().setValue(i,"morphTargetBaseInfluence",g),l.getUniforms().setValue(i,"morphTargetInfluences",c)}l.getUniforms().setValue(i,"morphTargetsTexture",u.texture,e),l.getUniforms().setValue(i,"morphTargetsTextureSize",u.size)}return{update:r}}function uw(i,t,e,n,s){let r=new WeakMap;function o(c){let h=s.render.frame,f=c.geometry,u=t.get(c,f);if(r.get(u)!==h&&(t.update(u),r.set(u,h)),c.isInstancedMesh&&(c.hasEventListener("dispose",l)===!1&&c.addEventListener("dispose",l),r.get(c)!==h&&(e.update(c.instanceMatrix,i.ARRAY_BUFFER),c.instanceColor!==null&&e.update(c.instanceColor,i.ARRAY_BUFFER),r.set(c,h))),c.isSkinnedMesh){let d=c.skeleton;r.get(d)!==h&&(d.update(),r.set(d,h))}return u}function a(){r=new WeakMap}function l(c){let h=c.target;h.removeEventListener("dispose",l),n.releaseStatesOfObject(h),e.remove(h.instanceMatrix),h.instanceColor!==null&&e.remove(h.instanceColor)}return{update:o,dispose:a}}var fw={[Bf]:"LINEAR_TONE_MAPPING",[kf]:"REINHARD_TONE_MAPPING",[zf]:"CINEON_TONE_MAPPING",[Vf]:"ACES_FILMIC_TONE_MAPPING",[Gf]:"AGX_TONE_MAPPING",[Wf]:"NEUTRAL_TONE_MAPPING",[Hf]:"CUSTOM_TONE_MAPPING"};function dw(i,t,e,n,s,r){let o=new ci(t,e,{type:i,depthBuffer:s,stencilBuffer:r,samples:n?4:0,storeMultisampledDepthBuffer:!1,storeMultisampledStencilBuffer:!1,resolveDepthBuffer:!1,resolveStencilBuffer:!1}),a=null,l=null,c=null,h=new Fn;h.setAttribute("position",new bi([-1,3,0,-1,-1,0,3,-1,0],3)),h.setAttribute("uv",new bi([0,2,0,0,2,0],2));let f=new mc({uniforms:{tDiffuse:{value:null}},vertexShader:`
			precision highp float;

			uniform mat4 modelViewMatrix;
			uniform mat4 projectionMatrix;

			attribute vec3 position;
			attribute vec2 uv;

			varying vec2 vUv;

			void main() {
				vUv = uv;
				gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 );
			}`,fragmentShader:`
			precision highp float;

			uniform sampler2D tDiffuse;

			varying vec2 vUv;

			#include <tonemapping_pars_fragment>
			#include <colorspace_pars_fragment>

			void main() {
				gl_FragColor = texture2D( tDiffuse, vUv );

				#ifdef LINEAR_TONE_MAPPING
					gl_FragColor.rgb = LinearToneMapping( gl_FragColor.rgb );
				#elif defined( REINHARD_TONE_MAPPING )
					gl_FragColor.rgb = ReinhardToneMapping( gl_FragColor.rgb );
				#elif defined( CINEON_TONE_MAPPING )
					gl_FragColor.rgb = CineonToneMapping( gl_FragColor.rgb );
				#elif defined( ACES_FILMIC_TONE_MAPPING )
					gl_FragColor.rgb = ACESFilmicToneMapping( gl_FragColor.rgb );
				#elif defined( AGX_TONE_MAPPING )
					gl_FragColor.rgb = AgXToneMapping( gl_FragColor.rgb );
				#elif defined( NEUTRAL_TONE_MAPPING )
					gl_FragColor.rgb = NeutralToneMapping( gl_FragColor.rgb );
				#elif defined( CUSTOM_TONE_MAPPING )
					gl_FragColor.rgb = CustomToneMapping( gl_FragColor.rgb );
				#endif

				#ifdef SRGB_TRANSFER
					gl_FragColor = sRGBTransferOETF( gl_FragColor );
				#endif
			}`,depthTest:!1,depthWrite:!1}),u=new Cn(h,f),d=new Rc(-1,1,1,-1,0,1),g=null,M=null,m=!1,p,y=null,A=[],w=!1;this.setSize=function(P,T){o.setSize(P,T),a!==null&&a.setSize(P,T),l!==null&&l.setSize(P,T);for(let _=0;_<A.length;_++){let E=A[_];E.setSize&&E.setSize(P,T)}},this.setEffects=function(P){A=P,w=A.length>0&&A[0].isRenderPass===!0;let T=o.width,_=o.height;A.length>0&&a===null&&(a=new ci(T,_,{type:Di,depthBuffer:!1,stencilBuffer:!1}),l=new ci(T,_,{type:Di,depthBuffer:!1,stencilBuffer:!1}));let E=s===!0&&A.some(V=>V.needsDepthTexture===!0);E!==(o.depthTexture!==null)&&(E===!0&&c===null&&(c=new gs(T,_),r===!0&&(c.format=_s,c.type=Sr)),o.dispose(),o.depthTexture=E?c:null,o.resolveDepthBuffer=E,o.storeMultisampledDepthBuffer=E);for(let V=0;V<A.length;V++){let D=A[V];D.setSize&&D.setSize(T,_),E&&D.needsDepthTexture===!0&&D.setDepthTexture&&D.setDepthTexture(c)}},this.begin=function(P,T){if(m||P.toneMapping===ji&&A.length===0)return!1;if(y=T,T!==null){let _=T.width,E=T.height;(o.width!==_||o.height!==E)&&this.setSize(_,E)}return w===!1&&P.setRenderTarget(o),p=P.toneMapping,P.toneMapping=ji,!0},this.hasRenderPass=function(){return w},this.end=function(P,T){P.toneMapping=p,m=!0;let _=o,E=a;for(let V=0;V<A.length;V++){let D=A[V];D.enabled!==!1&&(D.render(P,E,_,T),D.needsSwap!==!1&&(_=E,E=E===a?l:a))}if(g!==P.outputColorSpace||M!==P.toneMapping){g=P.outputColorSpace,M=P.toneMapping,f.defines={},ge.getTransfer(g)===Re&&(f.defines.SRGB_TRANSFER="");let V=fw[M];V&&(f.defines[V]=""),f.needsUpdate=!0}f.uniforms.tDiffuse.value=_.texture,P.setRenderTarget(y),P.render(u,d),y=null,m=!1},this.isCompositing=function(){return m},this.dispose=function(){o.dispose(),a!==null&&a.dispose(),l!==null&&l.dispose(),h.dispose(),f.dispose()}}var j0=new Jn,Q0=new gs(1,1),tx=new ua(1),ex=new na,nx=new hc,ix=new ca,I0=[],L0=[],N0=new Float32Array(16),D0=new Float32Array(9),U0=new Float32Array(4);function wo(i,t,e){let n=i[0];if(n<=0||n>0)return i;let s=t*e,r=I0[s];if(r===void 0&&(r=new Float32Array(s),I0[s]=r),t!==0){n.toArray(r,0);for(let o=1,a=0;o!==t;++o)a+=e,i[o].toArray(r,a)}return r}function yn(i,t){if(i.length!==t.length)return!1;for(let e=0,n=i.length;e<n;e++)if(i[e]!==t[e])return!1;return!0}function bn(i,t){for(let e=0,n=t.length;e<n;e++)i[e]=t[e]}function Sh(i,t){let e=L0[t];e===void 0&&(e=new Int32Array(t),L0[t]=e);for(let n=0;n!==t;++n)e[n]=i.allocateTextureUnit();return e}function pw(i,t){let e=this.cache;e[0]!==t&&(i.uniform1f(this.addr,t),e[0]=t)}function mw(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y)&&(i.uniform2f(this.addr,t.x,t.y),e[0]=t.x,e[1]=t.y);else{if(yn(e,t))return;i.uniform2fv(this.addr,t),bn(e,t)}}function gw(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z)&&(i.uniform3f(this.addr,t.x,t.y,t.z),e[0]=t.x,e[1]=t.y,e[2]=t.z);else if(t.r!==void 0)(e[0]!==t.r||e[1]!==t.g||e[2]!==t.b)&&(i.uniform3f(this.addr,t.r,t.g,t.b),e[0]=t.r,e[1]=t.g,e[2]=t.b);else{if(yn(e,t))return;i.uniform3fv(this.addr,t),bn(e,t)}}function xw(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z||e[3]!==t.w)&&(i.uniform4f(this.addr,t.x,t.y,t.z,t.w),e[0]=t.x,e[1]=t.y,e[2]=t.z,e[3]=t.w);else{if(yn(e,t))return;i.uniform4fv(this.addr,t),bn(e,t)}}function _w(i,t){let e=this.cache,n=t.elements;if(n===void 0){if(yn(e,t))return;i.uniformMatrix2fv(this.addr,!1,t),bn(e,t)}else{if(yn(e,n))return;U0.set(n),i.uniformMatrix2fv(this.addr,!1,U0),bn(e,n)}}function vw(i,t){let e=this.cache,n=t.elements;if(n===void 0){if(yn(e,t))return;i.uniformMatrix3fv(this.addr,!1,t),bn(e,t)}else{if(yn(e,n))return;D0.set(n),i.uniformMatrix3fv(this.addr,!1,D0),bn(e,n)}}function yw(i,t){let e=this.cache,n=t.elements;if(n===void 0){if(yn(e,t))return;i.uniformMatrix4fv(this.addr,!1,t),bn(e,t)}else{if(yn(e,n))return;N0.set(n),i.uniformMatrix4fv(this.addr,!1,N0),bn(e,n)}}function bw(i,t){let e=this.cache;e[0]!==t&&(i.uniform1i(this.addr,t),e[0]=t)}function Sw(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y)&&(i.uniform2i(this.addr,t.x,t.y),e[0]=t.x,e[1]=t.y);else{if(yn(e,t))return;i.uniform2iv(this.addr,t),bn(e,t)}}function Mw(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z)&&(i.uniform3i(this.addr,t.x,t.y,t.z),e[0]=t.x,e[1]=t.y,e[2]=t.z);else{if(yn(e,t))return;i.uniform3iv(this.addr,t),bn(e,t)}}function ww(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z||e[3]!==t.w)&&(i.uniform4i(this.addr,t.x,t.y,t.z,t.w),e[0]=t.x,e[1]=t.y,e[2]=t.z,e[3]=t.w);else{if(yn(e,t))return;i.uniform4iv(this.addr,t),bn(e,t)}}function Ew(i,t){let e=this.cache;e[0]!==t&&(i.uniform1ui(this.addr,t),e[0]=t)}function Tw(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y)&&(i.uniform2ui(this.addr,t.x,t.y),e[0]=t.x,e[1]=t.y);else{if(yn(e,t))return;i.uniform2uiv(this.addr,t),bn(e,t)}}function Aw(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z)&&(i.uniform3ui(this.addr,t.x,t.y,t.z),e[0]=t.x,e[1]=t.y,e[2]=t.z);else{if(yn(e,t))return;i.uniform3uiv(this.addr,t),bn(e,t)}}function Rw(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z||e[3]!==t.w)&&(i.uniform4ui(this.addr,t.x,t.y,t.z,t.w),e[0]=t.x,e[1]=t.y,e[2]=t.z,e[3]=t.w);else{if(yn(e,t))return;i.uniform4uiv(this.addr,t),bn(e,t)}}function Mh(i){return i.version===0&&(i.compareFunction=nd,i.needsUpdate=!0),i}function Cw(i,t,e){let n=this.cache,s=e.allocateTextureUnit();n[0]!==s&&(i.uniform1i(this.addr,s),n[0]=s);let r;this.type===i.SAMPLER_2D_SHADOW?r=Mh(Q0):r=j0,e.setTexture2D(t||r,s)}function Pw(i,t,e){let n=this.cache,s=e.allocateTextureUnit();n[0]!==s&&(i.uniform1i(this.addr,s),n[0]=s),e.setTexture3D(t||nx,s)}function Iw(i,t,e){let n=this.cache,s=e.allocateTextureUnit();n[0]!==s&&(i.uniform1i(this.addr,s),n[0]=s);let r;this.type===i.SAMPLER_CUBE_SHADOW?r=Mh(tx):r=ix,e.setTextureCube(t||r,s)}function Lw(i,t,e){let n=this.cache,s=e.allocateTextureUnit();n[0]!==s&&(i.uniform1i(this.addr,s),n[0]=s),e.setTexture2DArray(t||ex,s)}function Nw(i){switch(i){case 5126:return pw;case 35664:return mw;case 35665:return gw;case 35666:return xw;case 35674:return _w;case 35675:return vw;case 35676:return yw;case 5124:case 35670:return bw;case 35667:case 35671:return Sw;case 35668:case 35672:return Mw;case 35669:case 35673:return ww;case 5125:return Ew;case 36294:return Tw;case 36295:return Aw;case 36296:return Rw;case 35678:case 36198:case 36298:case 36306:case 35682:return Cw;case 35679:case 36299:case 36307:return Pw;case 35680:case 36300:case 36308:case 36293:return Iw;case 36289:case 36303:case 36311:case 36292:return Lw}}function Dw(i,t){i.uniform1fv(this.addr,t)}function Uw(i,t){let e=wo(t,this.size,2);i.uniform2fv(this.addr,e)}function Fw(i,t){let e=wo(t,this.size,3);i.uniform3fv(this.addr,e)}function Ow(i,t){let e=wo(t,this.size,4);i.uniform4fv(this.addr,e)}function Bw(i,t){let e=wo(t,this.size,4);i.uniformMatrix2fv(this.addr,!1,e)}function kw(i,t){let e=wo(t,this.size,9);i.uniformMatrix3fv(this.addr,!1,e)}function zw(i,t){let e=wo(t,this.size,16);i.uniformMatrix4fv(this.addr,!1,e)}function Vw(i,t){i.uniform1iv(this.addr,t)}function Hw(i,t){i.uniform2iv(this.addr,t)}function Gw(i,t){i.uniform3iv(this.addr,t)}function Ww(i,t){i.uniform4iv(this.addr,t)}function Xw(i,t){i.uniform1uiv(this.addr,t)}function qw(i,t){i.uniform2uiv(this.addr,t)}function $w(i,t){i.uniform3uiv(this.addr,t)}function Yw(i,t){i.uniform4uiv(this.addr,t)}function Zw(i,t,e){let n=this.cache,s=t.length,r=Sh(e,s);yn(n,r)||(i.uniform1iv(this.addr,r),bn(n,r));let o;this.type===i.SAMPLER_2D_SHADOW?o=Mh(Q0):o=j0;for(let a=0;a!==s;++a)e.setTexture2D(t[a]||o,r[a])}function Jw(i,t,e){let n=this.cache,s=t.length,r=Sh(e,s);yn(n,r)||(i.uniform1iv(this.addr,r),bn(n,r));for(let o=0;o!==s;++o)e.setTexture3D(t[o]||nx,r[o])}function Kw(i,t,e){let n=this.cache,s=t.length,r=Sh(e,s);yn(n,r)||(i.uniform1iv(this.addr,r),bn(n,r));let o;this.type===i.SAMPLER_CUBE_SHADOW?o=Mh(tx):o=ix;for(let a=0;a!==s;++a)e.setTextureCube(t[a]||o,r[a])}function jw(i,t,e){let n=this.cache,s=t.length,r=Sh(e,s);yn(n,r)||(i.uniform1iv(this.addr,r),bn(n,r));for(let o=0;o!==s;++o)e.setTexture2DArray(t[o]||ex,r[o])}function Qw(i){switch(i){case 5126:return Dw;case 35664:return Uw;case 35665:return Fw;case 35666:return Ow;case 35674:return Bw;case 35675:return kw;case 35676:return zw;case 5124:case 35670:return Vw;case 35667:case 35671:return Hw;case 35668:case 35672:return Gw;case 35669:case 35673:return Ww;case 5125:return Xw;case 36294:return qw;case 36295:return $w;case 36296:return Yw;case 35678:case 36198:case 36298:case 36306:case 35682:return Zw;case 35679:case 36299:case 36307:return Jw;case 35680:case 36300:case 36308:case 36293:return Kw;case 36289:case 36303:case 36311:case 36292:return jw}}var ud=class{constructor(t,e,n){this.id=t,this.addr=n,this.cache=[],this.type=e.type,this.setValue=Nw(e.type)}},fd=class{constructor(t,e,n){this.id=t,this.addr=n,this.cache=[],this.type=e.type,this.size=e.size,this.setValue=Qw(e.type)}},dd=class{constructor(t){this.id=t,this.seq=[],this.map={}}setValue(t,e,n){let s=this.seq;for(let r=0,o=s.length;r!==o;++r){let a=s[r];a.setValue(t,e[a.id],n)}}},cd=/(\w+)(\])?(\[|\.)?/g;function F0(i,t){i.seq.push(t),i.map[t.id]=t}function tE(i,t,e){let n=i.name,s=n.length;for(cd.lastIndex=0;;){let r=cd.exec(n),o=cd.lastIndex,a=r[1],l=r[2]==="]",c=r[3];if(l&&(a=a|0),c===void 0||c==="["&&o+2===s){F0(e,c===void 0?new ud(a,i,t):new fd(a,i,t));break}else{let f=e.map[a];f===void 0&&(f=new dd(a),F0(e,f)),e=f}}}var Mo=class{constructor(t,e){this.seq=[],this.map={};let n=t.getProgramParameter(e,t.ACTIVE_UNIFORMS);for(let o=0;o<n;++o){let a=t.getActiveUniform(e,o),l=t.getUniformLocation(e,a.name);tE(a,l,this)}let s=[],r=[];for(let o of this.seq)o.type===t.SAMPLER_2D_SHADOW||o.type===t.SAMPLER_CUBE_SHADOW||o.type===t.SAMPLER_2D_ARRAY_SHADOW?s.push(o):r.push(o);s.length>0&&(this.seq=s.concat(r))}setValue(t,e,n,s){let r=this.map[e];r!==void 0&&r.setValue(t,n,s)}setOptional(t,e,n){let s=e[n];s!==void 0&&this.setValue(t,n,s)}static upload(t,e,n,s){for(let r=0,o=e.length;r!==o;++r){let a=e[r],l=n[a.id];l.needsUpdate!==!1&&a.setValue(t,l.value,s)}}static seqWithValue(t,e){let n=[];for(let s=0,r=t.length;s!==r;++s){let o=t[s];o.id in e&&n.push(o)}return n}};function O0(i,t,e){let n=i.createShader(t);return i.shaderSource(n,e),i.compileShader(n),n}var eE=37297,nE=0;function iE(i,t){let e=i.split(`
`),n=[],s=Math.max(t-6,0),r=Math.min(t+6,e.length);for(let o=s;o<r;o++){let a=o+1;n.push(`${a===t?">":" "} ${a}: ${e[o]}`)}return n.join(`
`)}var B0=new ie;function sE(i){ge._getMatrix(B0,ge.workingColorSpace,i);let t=`mat3( ${B0.elements.map(e=>e.toFixed(4))} )`;switch(ge.getTransfer(i)){case jo:return[t,"LinearTransferOETF"];case Re:return[t,"sRGBTransferOETF"];default:return jt("WebGLProgram: Unsupported color space: ",i),[t,"LinearTransferOETF"]}}function k0(i,t,e){let n=i.getShaderParameter(t,i.COMPILE_STATUS),r=(i.getShaderInfoLog(t)||"").trim();if(n&&r==="")return"";let o=/ERROR: 0:(\d+)/.exec(r);if(o){let a=parseInt(o[1]);return e.toUpperCase()+`

`+r+`

`+iE(i.getShaderSource(t),a)}else return r}function rE(i,t){let e=sE(t);return[`vec4 ${i}( vec4 value ) {`,`	return ${e[1]}( vec4( ${e[0]} * value.rgb, value.a ) );`,"}"].join(`
`)}var oE={[Bf]:"Linear",[kf]:"Reinhard",[zf]:"Cineon",[Vf]:"ACESFilmic",[Gf]:"AgX",[Wf]:"Neutral",[Hf]:"Custom"};function aE(i,t){let e=oE[t];return e===void 0?(jt("WebGLProgram: Unsupported toneMapping:",t),"vec3 "+i+"( vec3 color ) { return LinearToneMapping( color ); }"):"vec3 "+i+"( vec3 color ) { return "+e+"ToneMapping( color ); }"}var vh=new q;function lE(){ge.getLuminanceCoefficients(vh);let i=vh.x.toFixed(4),t=vh.y.toFixed(4),e=vh.z.toFixed(4);return["float luminance( const in vec3 rgb ) {",`	const vec3 weights = vec3( ${i}, ${t}, ${e} );`,"	return dot( weights, rgb );","}"].join(`
`)}function cE(i){return[i.extensionClipCullDistance?"#extension GL_ANGLE_clip_cull_distance : require":"",i.extensionMultiDraw?"#extension GL_ANGLE_multi_draw : require":""].filter(Aa).join(`
`)}function hE(i){let t=[];for(let e in i){let n=i[e];n!==!1&&t.push("#define "+e+" "+n)}return t.join(`
`)}function uE(i,t){let e={},n=i.getProgramParameter(t,i.ACTIVE_ATTRIBUTES);for(let s=0;s<n;s++){let r=i.getActiveAttrib(t,s),o=r.name,a=1;r.type===i.FLOAT_MAT2&&(a=2),r.type===i.FLOAT_MAT3&&(a=3),r.type===i.FLOAT_MAT4&&(a=4),e[o]={type:r.type,location:i.getAttribLocation(t,o),locationSize:a}}return e}function Aa(i){return i!==""}function z0(i,t){let e=t.numSpotLightShadows+t.numSpotLightMaps-t.numSpotLightShadowsWithMaps;return i.replace(/NUM_SUN_LIGHTS/g,t.numSunLights).replace(/NUM_DIR_LIGHTS/g,t.numDirLights).replace(/NUM_SPOT_LIGHTS/g,t.numSpotLights).replace(/NUM_SPOT_LIGHT_MAPS/g,t.numSpotLightMaps).replace(/NUM_SPOT_LIGHT_COORDS/g,e).replace(/NUM_RECT_AREA_LIGHTS/g,t.numRectAreaLights).replace(/NUM_POINT_LIGHTS/g,t.numPointLights).replace(/NUM_HEMI_LIGHTS/g,t.numHemiLights).replace(/NUM_SUN_LIGHT_SHADOWS/g,t.numSunLightShadows).replace(/NUM_DIR_LIGHT_SHADOWS/g,t.numDirLightShadows).replace(/NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS/g,t.numSpotLightShadowsWithMaps).replace(/NUM_SPOT_LIGHT_SHADOWS/g,t.numSpotLightShadows).replace(/NUM_POINT_LIGHT_SHADOWS/g,t.numPointLightShadows).replace(/NUM_LIGHT_PROBE_GRIDS/g,t.numLightProbeGrids)}function V0(i,t){return i.replace(/NUM_CLIPPING_PLANES/g,t.numClippingPlanes).replace(/UNION_CLIPPING_PLANES/g,t.numClippingPlanes-t.numClipIntersection)}var fE=/^[ \t]*#include +<([\w\d./]+)>/gm;function pd(i){return i.replace(fE,dE)}function dE(i,t){let e=fe[t];if(e===void 0)throw new Error("THREE.WebGLProgram: Can not resolve #include <"+t+">");return pd(e)}var pE=/#pragma unroll_loop_start\s+for\s*\(\s*int\s+i\s*=\s*(\d+)\s*;\s*i\s*<\s*(\d+)\s*;\s*i\s*\+\+\s*\)\s*{([\s\S]+?)}\s+#pragma unroll_loop_end/g;function H0(i){return i.replace(pE,mE)}function mE(i,t,e,n){let s="";for(let r=parseInt(t);r<parseInt(e);r++)s+=n.replace(/\[\s*i\s*\]/g,"[ "+r+" ]").replace(/UNROLLED_LOOP_INDEX/g,r);return s}function G0(i){let t=`precision ${i.precision} float;
	precision ${i.precision} int;
	precision ${i.precision} sampler2D;
	precision ${i.precision} samplerCube;
	precision ${i.precision} sampler3D;
	precision ${i.precision} sampler2DArray;
	precision ${i.precision} sampler2DShadow;
	precision ${i.precision} samplerCubeShadow;
	precision ${i.precision} sampler2DArrayShadow;
	precision ${i.precision} isampler2D;
	precision ${i.precision} isampler3D;
	precision ${i.precision} isamplerCube;
	precision ${i.precision} isampler2DArray;
	precision ${i.precision} usampler2D;
	precision ${i.precision} usampler3D;
	precision ${i.precision} usamplerCube;
	precision ${i.precision} usampler2DArray;
	`;return i.precision==="highp"?t+=`
#define HIGH_PRECISION`:i.precision==="mediump"?t+=`
#define MEDIUM_PRECISION`:i.precision==="lowp"&&(t+=`
#define LOW_PRECISION`),t}var gE={[xa]:"SHADOWMAP_TYPE_PCF",[vo]:"SHADOWMAP_TYPE_VSM"};function xE(i){return gE[i.shadowMapType]||"SHADOWMAP_TYPE_BASIC"}var _E={[bo]:"ENVMAP_MODE_REFRACTION"};function vE(i){return i.envMap===!1?"ENVMAP_MODE_REFLECTION":_E[i.envMapMode]||"ENVMAP_MODE_REFLECTION"}var yE={[Of]:"ENVMAP_BLENDING_MULTIPLY",[r0]:"ENVMAP_BLENDING_MIX",[o0]:"ENVMAP_BLENDING_ADD"};function bE(i){return i.envMap===!1?"ENVMAP_BLENDING_NONE":yE[i.combine]||"ENVMAP_BLENDING_NONE"}function SE(i,t,e,n){let s=i.getContext(),r=e.defines,o=e.vertexShader,a=e.fragmentShader,l=xE(e),c=e.envMapPMREM===!0?"ENVMAP_TYPE_PMREM":"ENVMAP_TYPE_CUBE",h=vE(e),f=bE(e),u=cE(e),d=hE(r),g=s.createProgram(),M,m,p=e.glslVersion?"#version "+e.glslVersion+`
`:"";e.isRawShaderMaterial?(M=["#define SHADER_TYPE "+e.shaderType,"#define SHADER_NAME "+e.shaderName,d].filter(Aa).join(`
`),M.length>0&&(M+=`
`),m=["#define SHADER_TYPE "+e.shaderType,"#define SHADER_NAME "+e.shaderName,d].filter(Aa).join(`
`),m.length>0&&(m+=`
`)):(M=[G0(e),"#define SHADER_TYPE "+e.shaderType,"#define SHADER_NAME "+e.shaderName,d,e.extensionClipCullDistance?"#define USE_CLIP_DISTANCE":"",e.batching?"#define USE_BATCHING":"",e.batchingColor?"#define USE_BATCHING_COLOR":"",e.instancing?"#define USE_INSTANCING":"",e.instancingColor?"#define USE_INSTANCING_COLOR":"",e.instancingMorph?"#define USE_INSTANCING_MORPH":"",e.useFog&&e.fog?"#define USE_FOG":"",e.useFog&&e.fogExp2?"#define FOG_EXP2":"",e.map?"#define USE_MAP":"",e.envMap?"#define USE_ENVMAP":"",e.envMap?"#define "+h:"",e.lightMap?"#define USE_LIGHTMAP":"",e.aoMap?"#define USE_AOMAP":"",e.bumpMap?"#define USE_BUMPMAP":"",e.normalMap?"#define USE_NORMALMAP":"",e.normalMapObjectSpace?"#define USE_NORMALMAP_OBJECTSPACE":"",e.normalMapTangentSpace?"#define USE_NORMALMAP_TANGENTSPACE":"",e.displacementMap?"#define USE_DISPLACEMENTMAP":"",e.emissiveMap?"#define USE_EMISSIVEMAP":"",e.anisotropy?"#define USE_ANISOTROPY":"",e.anisotropyMap?"#define USE_ANISOTROPYMAP":"",e.clearcoatMap?"#define USE_CLEARCOATMAP":"",e.clearcoatRoughnessMap?"#define USE_CLEARCOAT_ROUGHNESSMAP":"",e.clearcoatNormalMap?"#define USE_CLEARCOAT_NORMALMAP":"",e.diffuseRoughnessMap?"#define USE_DIFFUSE_ROUGHNESSMAP":"",e.iridescenceMap?"#define USE_IRIDESCENCEMAP":"",e.iridescenceThicknessMap?"#define USE_IRIDESCENCE_THICKNESSMAP":"",e.specularMap?"#define USE_SPECULARMAP":"",e.specularColorMap?"#define USE_SPECULAR_COLORMAP":"",e.specularIntensityMap?"#define USE_SPECULAR_INTENSITYMAP":"",e.roughnessMap?"#define USE_ROUGHNESSMAP":"",e.metalnessMap?"#define USE_METALNESSMAP":"",e.alphaMap?"#define USE_ALPHAMAP":"",e.alphaHash?"#define USE_ALPHAHASH":"",e.transmission?"#define USE_TRANSMISSION":"",e.transmissionMap?"#define USE_TRANSMISSIONMAP":"",e.thicknessMap?"#define USE_THICKNESSMAP":"",e.sheenColorMap?"#define USE_SHEEN_COLORMAP":"",e.sheenRoughnessMap?"#define USE_SHEEN_ROUGHNESSMAP":"",e.mapUv?"#define MAP_UV "+e.mapUv:"",e.alphaMapUv?"#define ALPHAMAP_UV "+e.alphaMapUv:"",e.lightMapUv?"#define LIGHTMAP_UV "+e.lightMapUv:"",e.aoMapUv?"#define AOMAP_UV "+e.aoMapUv:"",e.emissiveMapUv?"#define EMISSIVEMAP_UV "+e.emissiveMapUv:"",e.bumpMapUv?"#define BUMPMAP_UV "+e.bumpMapUv:"",e.normalMapUv?"#define NORMALMAP_UV "+e.normalMapUv:"",e.displacementMapUv?"#define DISPLACEMENTMAP_UV "+e.displacementMapUv:"",e.metalnessMapUv?"#define METALNESSMAP_UV "+e.metalnessMapUv:"",e.roughnessMapUv?"#define ROUGHNESSMAP_UV "+e.roughnessMapUv:"",e.anisotropyMapUv?"#define ANISOTROPYMAP_UV "+e.anisotropyMapUv:"",e.clearcoatMapUv?"#define CLEARCOATMAP_UV "+e.clearcoatMapUv:"",e.clearcoatNormalMapUv?"#define CLEARCOAT_NORMALMAP_UV "+e.clearcoatNormalMapUv:"",e.clearcoatRoughnessMapUv?"#define CLEARCOAT_ROUGHNESSMAP_UV "+e.clearcoatRoughnessMapUv:"",e.diffuseRoughnessMapUv?"#define DIFFUSE_ROUGHNESSMAP_UV "+e.diffuseRoughnessMapUv:"",e.iridescenceMapUv?"#define IRIDESCENCEMAP_UV "+e.iridescenceMapUv:"",e.iridescenceThicknessMapUv?"#define IRIDESCENCE_THICKNESSMAP_UV "+e.iridescenceThicknessMapUv:"",e.sheenColorMapUv?"#define SHEEN_COLORMAP_UV "+e.sheenColorMapUv:"",e.sheenRoughnessMapUv?"#define SHEEN_ROUGHNESSMAP_UV "+e.sheenRoughnessMapUv:"",e.specularMapUv?"#define SPECULARMAP_UV "+e.specularMapUv:"",e.specularColorMapUv?"#define SPECULAR_COLORMAP_UV "+e.specularColorMapUv:"",e.specularIntensityMapUv?"#define SPECULAR_INTENSITYMAP_UV "+e.specularIntensityMapUv:"",e.transmissionMapUv?"#define TRANSMISSIONMAP_UV "+e.transmissionMapUv:"",e.thicknessMapUv?"#define THICKNESSMAP_UV "+e.thicknessMapUv:"",e.vertexTangents&&e.flatShading===!1?"#define USE_TANGENT":"",e.vertexNormals?"#define HAS_NORMAL":"",e.vertexColors?"#define USE_COLOR":"",e.vertexAlphas?"#define USE_COLOR_ALPHA":"",e.vertexUv1s?"#define USE_UV1":"",e.vertexUv2s?"#define USE_UV2":"",e.vertexUv3s?"#define USE_UV3":"",e.pointsUvs?"#define USE_POINTS_UV":"",e.flatShading?"#define FLAT_SHADED":"",e.skinning?"#define USE_SKINNING":"",e.morphTargets?"#define USE_MORPHTARGETS":"",e.morphNormals&&e.flatShading===!1?"#define USE_MORPHNORMALS":"",e.morphColors?"#define USE_MORPHCOLORS":"",e.morphTargetsCount>0?"#define MORPHTARGETS_TEXTURE_STRIDE "+e.morphTextureStride:"",e.morphTargetsCount>0?"#define MORPHTARGETS_COUNT "+e.morphTargetsCount:"",e.doubleSided?"#define DOUBLE_SIDED":"",e.flipSided?"#define FLIP_SIDED":"",e.shadowMapEnabled?"#define USE_SHADOWMAP":"",e.shadowMapEnabled?"#define "+l:"",e.sizeAttenuation?"#define USE_SIZEATTENUATION":"",e.numLightProbes>0?"#define USE_LIGHT_PROBES":"",e.logarithmicDepthBuffer?"#define USE_LOGARITHMIC_DEPTH_BUFFER":"",e.reversedDepthBuffer?"#define USE_REVERSED_DEPTH_BUFFER":"","uniform mat4 modelMatrix;","uniform mat4 modelViewMatrix;","uniform mat4 projectionMatrix;","uniform mat4 viewMatrix;","uniform mat3 normalMatrix;","uniform vec3 cameraPosition;","uniform bool isOrthographic;","#ifdef USE_INSTANCING","	attribute mat4 instanceMatrix;","#endif","#ifdef USE_INSTANCING_COLOR","	attribute vec3 instanceColor;","#endif","#ifdef USE_INSTANCING_MORPH","	uniform sampler2D morphTexture;","#endif","attribute vec3 position;","attribute vec3 normal;","attribute vec2 uv;","#ifdef USE_UV1","	attribute vec2 uv1;","#endif","#ifdef USE_UV2","	attribute vec2 uv2;","#endif","#ifdef USE_UV3","	attribute vec2 uv3;","#endif","#ifdef USE_TANGENT","	attribute vec4 tangent;","#endif","#if defined( USE_COLOR_ALPHA )","	attribute vec4 color;","#elif defined( USE_COLOR )","	attribute vec3 color;","#endif","#ifdef USE_SKINNING","	attribute vec4 skinIndex;","	attribute vec4 skinWeight;","#endif",`
`].filter(Aa).join(`
`),m=[G0(e),"#define SHADER_TYPE "+e.shaderType,"#define SHADER_NAME "+e.shaderName,d,e.useFog&&e.fog?"#define USE_FOG":"",e.useFog&&e.fogExp2?"#define FOG_EXP2":"",e.alphaToCoverage?"#define ALPHA_TO_COVERAGE":"",e.map?"#define USE_MAP":"",e.matcap?"#define USE_MATCAP":"",e.envMap?"#define USE_ENVMAP":"",e.envMap?"#define "+c:"",e.envMap?"#define "+h:"",e.envMap?"#define "+f:"",e.envMapPMREM?"#define ENVMAP_MAX_LOD "+e.envMapMaxLod+".0":"",e.envMapPMREM?"#define ENVMAP_SIZE "+e.envMapSize+".0":"",e.lightMap?"#define USE_LIGHTMAP":"",e.aoMap?"#define USE_AOMAP":"",e.bumpMap?"#define USE_BUMPMAP":"",e.normalMap?"#define USE_NORMALMAP":"",e.normalMapObjectSpace?"#define USE_NORMALMAP_OBJECTSPACE":"",e.normalMapTangentSpace?"#define USE_NORMALMAP_TANGENTSPACE":"",e.packedNormalMap?"#define USE_PACKED_NORMALMAP":"",e.emissiveMap?"#define USE_EMISSIVEMAP":"",e.anisotropy?"#define USE_ANISOTROPY":"",e.anisotropyMap?"#define USE_ANISOTROPYMAP":"",e.clearcoat?"#define USE_CLEARCOAT":"",e.clearcoatMap?"#define USE_CLEARCOATMAP":"",e.clearcoatRoughnessMap?"#define USE_CLEARCOAT_ROUGHNESSMAP":"",e.clearcoatNormalMap?"#define USE_CLEARCOAT_NORMALMAP":"",e.diffuseRoughness?"#define USE_DIFFUSE_ROUGHNESS":"",e.diffuseRoughnessMap?"#define USE_DIFFUSE_ROUGHNESSMAP":"",e.dispersion?"#define USE_DISPERSION":"",e.retroreflection?"#define USE_RETROREFLECTION":"",e.iridescence?"#define USE_IRIDESCENCE":"",e.iridescenceMap?"#define USE_IRIDESCENCEMAP":"",e.iridescenceThicknessMap?"#define USE_IRIDESCENCE_THICKNESSMAP":"",e.specularMap?"#define USE_SPECULARMAP":"",e.specularColorMap?"#define USE_SPECULAR_COLORMAP":"",e.specularIntensityMap?"#define USE_SPECULAR_INTENSITYMAP":"",e.roughnessMap?"#define USE_ROUGHNESSMAP":"",e.metalnessMap?"#define USE_METALNESSMAP":"",e.alphaMap?"#define USE_ALPHAMAP":"",e.alphaTest?"#define USE_ALPHATEST":"",e.alphaHash?"#define USE_ALPHAHASH":"",e.sheen?"#define USE_SHEEN":"",e.sheenColorMap?"#define USE_SHEEN_COLORMAP":"",e.sheenRoughnessMap?"#define USE_SHEEN_ROUGHNESSMAP":"",e.transmission?"#define USE_TRANSMISSION":"",e.transmissionMap?"#define USE_TRANSMISSIONMAP":"",e.thicknessMap?"#define USE_THICKNESSMAP":"",e.vertexTangents&&e.flatShading===!1?"#define USE_TANGENT":"",e.vertexColors||e.instancingColor?"#define USE_COLOR":"",e.vertexAlphas||e.batchingColor?"#define USE_COLOR_ALPHA":"",e.vertexUv1s?"#define USE_UV1":"",e.vertexUv2s?"#define USE_UV2":"",e.vertexUv3s?"#define USE_UV3":"",e.pointsUvs?"#define USE_POINTS_UV":"",e.gradientMap?"#define USE_GRADIENTMAP":"",e.flatShading?"#define FLAT_SHADED":"",e.doubleSided?"#define DOUBLE_SIDED":"",e.flipSided?"#define FLIP_SIDED":"",e.shadowMapEnabled?"#define USE_SHADOWMAP":"",e.shadowMapEnabled?"#define "+l:"",e.premultipliedAlpha?"#define PREMULTIPLIED_ALPHA":"",e.numLightProbes>0?"#define USE_LIGHT_PROBES":"",e.decodeVideoTexture?"#define DECODE_VIDEO_TEXTURE":"",e.decodeVideoTextureEmissive?"#define DECODE_VIDEO_TEXTURE_EMISSIVE":"",e.logarithmicDepthBuffer?"#define USE_LOGARITHMIC_DEPTH_BUFFER":"",e.reversedDepthBuffer?"#define USE_REVERSED_DEPTH_BUFFER":"","uniform mat4 viewMatrix;","uniform vec3 cameraPosition;","uniform bool isOrthographic;",e.toneMapping!==ji?"#define TONE_MAPPING":"",e.toneMapping!==ji?fe.tonemapping_pars_fragment:"",e.toneMapping!==ji?aE("toneMapping",e.toneMapping):"",e.dithering?"#define DITHERING":"",e.opaque?"#define OPAQUE":"",fe.colorspace_pars_fragment,rE("linearToOutputTexel",e.outputColorSpace),lE(),e.useDepthPacking?"#define DEPTH_PACKING "+e.depthPacking:"",`
`].filter(Aa).join(`
`)),o=pd(o),o=z0(o,e),o=V0(o,e),a=pd(a),a=z0(a,e),a=V0(a,e),o=H0(o),a=H0(a),e.isRawShaderMaterial!==!0&&(p=`#version 300 es
`,M=[u,"#define attribute in","#define varying out","#define texture2D texture"].join(`
`)+`
`+M,m=["#define varying in",e.glslVersion===sd?"":"layout(location = 0) out highp vec4 pc_fragColor;",e.glslVersion===sd?"":"#define gl_FragColor pc_fragColor","#define gl_FragDepthEXT gl_FragDepth","#define texture2D texture","#define textureCube texture","#define texture2DProj textureProj","#define texture2DLodEXT textureLod","#define texture2DProjLodEXT textureProjLod","#define textureCubeLodEXT textureLod","#define texture2DGradEXT textureGrad","#define texture2DProjGradEXT textureProjGrad","#define textureCubeGradEXT textureGrad"].join(`
`)+`
`+m);let y=p+M+o,A=p+m+a,w=O0(s,s.VERTEX_SHADER,y),P=O0(s,s.FRAGMENT_SHADER,A);s.attachShader(g,w),s.attachShader(g,P),e.index0AttributeName!==void 0?s.bindAttribLocation(g,0,e.index0AttributeName):e.hasPositionAttribute===!0&&s.bindAttribLocation(g,0,"position"),s.linkProgram(g);function T(D){if(i.debug.checkShaderErrors){let L=s.getProgramInfoLog(g)||"",H=s.getShaderInfoLog(w)||"",G=s.getShaderInfoLog(P)||"",N=L.trim(),z=H.trim(),J=G.trim(),k=!0,ct=!0;if(s.getProgramParameter(g,s.LINK_STATUS)===!1)if(k=!1,typeof i.debug.onShaderError=="function")i.debug.onShaderError(s,g,w,P);else{let K=k0(s,w,"vertex"),Q=k0(s,P,"fragment");ne("WebGLProgram: Shader Error "+s.getError()+" - VALIDATE_STATUS "+s.getProgramParameter(g,s.VALIDATE_STATUS)+`

Material Name: `+D.name+`
Material Type: `+D.type+`

Program Info Log: `+N+`
`+K+`
`+Q)}else N!==""?jt("WebGLProgram: Program Info Log:",N):(z===""||J==="")&&(ct=!1);ct&&(D.diagnostics={runnable:k,programLog:N,vertexShader:{log:z,prefix:M},fragmentShader:{log:J,prefix:m}})}s.deleteShader(w),s.deleteShader(P),_=new Mo(s,g),E=uE(s,g)}let _;this.getUniforms=function(){return _===void 0&&T(this),_};let E;this.getAttributes=function(){return E===void 0&&T(this),E};let V=e.rendererExtensionParallelShaderCompile===!1;return this.isReady=function(){return V===!1&&(V=s.getProgramParameter(g,eE)),V},this.destroy=function(){n.releaseStatesOfProgram(this),s.deleteProgram(g),this.program=void 0},this.type=e.shaderType,this.name=e.shaderName,this.id=nE++,this.cacheKey=t,this.usedTimes=1,this.program=g,this.vertexShader=w,this.fragmentShader=P,this}var ME=0,md=class{constructor(){this.shaderCache=new Map,this.materialCache=new Map}update(t,e,n){let s=this._getShaderCacheForMaterial(t);return s.has(e)===!1&&(s.add(e),e.usedTimes++),s.has(n)===!1&&(s.add(n),n.usedTimes++),this}remove(t){let e=this.materialCache.get(t);for(let n of e)n.usedTimes--,n.usedTimes===0&&this.shaderCache.delete(n.code);return this.materialCache.delete(t),this}getVertexShaderStage(t){return this._getShaderStage(t.vertexShader)}getFragmentShaderStage(t){return this._getShaderStage(t.fragmentShader)}dispose(){this.shaderCache.clear(),this.materialCache.clear()}_getShaderCacheForMaterial(t){let e=this.materialCache,n=e.get(t);return n===void 0&&(n=new Set,e.set(t,n)),n}_getShaderStage(t){let e=this.shaderCache,n=e.get(t);return n===void 0&&(n=new gd(t),e.set(t,n)),n}},gd=class{constructor(t){this.id=ME++,this.code=t,this.usedTimes=0}};function wE(i){return i===Ys||i===wa||i===Ea}function EE(i,t,e,n,s,r){let o=new ia,a=new md,l=new Set,c=[],h=new Map,f=n.logarithmicDepthBuffer,u={MeshDepthMaterial:"depth",MeshDistanceMaterial:"distance",MeshNormalMaterial:"normal",MeshBasicMaterial:"basic",MeshLambertMaterial:"lambert",MeshPhongMaterial:"phong",MeshToonMaterial:"toon",MeshStandardMaterial:"physical",MeshPhysicalMaterial:"physical",MeshMatcapMaterial:"matcap",LineBasicMaterial:"basic",LineDashedMaterial:"dashed",PointsMaterial:"points",ShadowMaterial:"shadow",SpriteMaterial:"sprite"};function d(_){return l.add(_),_===0?"uv":`uv${_}`}function g(_,E,V,D,L,H){let G=D.fog,N=L.geometry,z=_.isMeshStandardMaterial||_.isMeshLambertMaterial||_.isMeshPhongMaterial?D.environment:null,J=_.isMeshStandardMaterial||_.isMeshLambertMaterial&&!_.envMap||_.isMeshPhongMaterial&&!_.envMap,k=t.get(_.envMap||z,J),ct=u[_.type],K=n.precision;_.precision!==null&&(K=n.getMaxPrecision(_.precision),K!==_.precision&&jt("WebGLProgram.getParameters:",_.precision,"not supported, using",K,"instead."));let Q=N.morphAttributes.position||N.morphAttributes.normal||N.morphAttributes.color,st=Q!==void 0?Q.length:0,ft=0;N.morphAttributes.position!==void 0&&(ft=1),N.morphAttributes.normal!==void 0&&(ft=2),N.morphAttributes.color!==void 0&&(ft=3);let ut,tt,mt,_t;if(ct){let Rt=ts[ct];ut=Rt.vertexShader,tt=Rt.fragmentShader}else{ut=_.vertexShader,tt=_.fragmentShader;let Rt=a.getVertexShaderStage(_),ce=a.getFragmentShaderStage(_);a.update(_,Rt,ce),mt=Rt.id,_t=ce.id}let At=i.getRenderTarget(),St=i.state.buffers.depth.getReversed(),Wt=L.isInstancedMesh===!0,oe=L.isBatchedMesh===!0,Vt=!!_.map,de=!!_.matcap,he=!!k,se=he&&k.isPMREMTexture===!0,$e=!!_.aoMap,Be=!!_.lightMap,an=!!_.bumpMap&&_.wireframe===!1,Le=!!_.normalMap,Sn=!!_.displacementMap,be=!!_.emissiveMap,gn=!!_.metalnessMap,je=!!_.roughnessMap,ln=_.anisotropy>0,F=_.clearcoat>0,Ct=_.diffuseRoughness>0,Zt=_.dispersion>0,ae=_.retroreflectivity>0,Mt=_.iridescence>0,Ue=_.sheen>0,zt=_.transmission>0,$t=ln&&!!_.anisotropyMap,R=F&&!!_.clearcoatMap,v=F&&!!_.clearcoatNormalMap,W=F&&!!_.clearcoatRoughnessMap,ht=Ct&&!!_.diffuseRoughnessMap,ot=Mt&&!!_.iridescenceMap,xt=Mt&&!!_.iridescenceThicknessMap,vt=Ue&&!!_.sheenColorMap,et=Ue&&!!_.sheenRoughnessMap,it=!!_.specularMap,pt=!!_.specularColorMap,U=!!_.specularIntensityMap,rt=zt&&!!_.transmissionMap,nt=zt&&!!_.thicknessMap,wt=!!_.gradientMap,gt=!!_.alphaMap,bt=_.alphaTest>0,Ht=!!_.alphaHash,Qt=!!_.extensions,lt=ji;_.toneMapped&&(At===null||At.isXRRenderTarget===!0)&&(lt=i.toneMapping);let Ot=se?k.isCompressedCubeTexture?k.image[0].mipmaps:k.mipmaps:null,te={shaderID:ct,shaderType:_.type,shaderName:_.name,vertexShader:ut,fragmentShader:tt,defines:_.defines,customVertexShaderID:mt,customFragmentShaderID:_t,isRawShaderMaterial:_.isRawShaderMaterial===!0,glslVersion:_.glslVersion,precision:K,batching:oe,batchingColor:oe&&L._colorsTexture!==null,instancing:Wt,instancingColor:Wt&&L.instanceColor!==null,instancingMorph:Wt&&L.morphTexture!==null,outputColorSpace:At===null?i.outputColorSpace:At.isXRRenderTarget===!0?At.texture.colorSpace:ge.workingColorSpace,alphaToCoverage:!!_.alphaToCoverage,map:Vt,matcap:de,envMap:he,envMapMode:he&&k.mapping,envMapPMREM:se,envMapMaxLod:se?Ot.length-1:null,envMapSize:se?Ot[0].width:null,aoMap:$e,lightMap:Be,bumpMap:an,normalMap:Le,displacementMap:Sn,emissiveMap:be,normalMapObjectSpace:Le&&_.normalMapType===c0,normalMapTangentSpace:Le&&_.normalMapType===Qf,packedNormalMap:Le&&_.normalMapType===Qf&&wE(_.normalMap.format),metalnessMap:gn,roughnessMap:je,anisotropy:ln,anisotropyMap:$t,clearcoat:F,clearcoatMap:R,clearcoatNormalMap:v,clearcoatRoughnessMap:W,diffuseRoughness:Ct,diffuseRoughnessMap:ht,dispersion:Zt,retroreflection:ae,iridescence:Mt,iridescenceMap:ot,iridescenceThicknessMap:xt,sheen:Ue,sheenColorMap:vt,sheenRoughnessMap:et,specularMap:it,specularColorMap:pt,specularIntensityMap:U,transmission:zt,transmissionMap:rt,thicknessMap:nt,gradientMap:wt,opaque:_.transparent===!1&&_.blending===yo&&_.alphaToCoverage===!1,alphaMap:gt,alphaTest:bt,alphaHash:Ht,combine:_.combine,mapUv:Vt&&d(_.map.channel),aoMapUv:$e&&d(_.aoMap.channel),lightMapUv:Be&&d(_.lightMap.channel),bumpMapUv:an&&d(_.bumpMap.channel),normalMapUv:Le&&d(_.normalMap.channel),displacementMapUv:Sn&&d(_.displacementMap.channel),emissiveMapUv:be&&d(_.emissiveMap.channel),metalnessMapUv:gn&&d(_.metalnessMap.channel),roughnessMapUv:je&&d(_.roughnessMap.channel),anisotropyMapUv:$t&&d(_.anisotropyMap.channel),clearcoatMapUv:R&&d(_.clearcoatMap.channel),clearcoatNormalMapUv:v&&d(_.clearcoatNormalMap.channel),clearcoatRoughnessMapUv:W&&d(_.clearcoatRoughnessMap.channel),diffuseRoughnessMapUv:ht&&d(_.diffuseRoughnessMap.channel),iridescenceMapUv:ot&&d(_.iridescenceMap.channel),iridescenceThicknessMapUv:xt&&d(_.iridescenceThicknessMap.channel),sheenColorMapUv:vt&&d(_.sheenColorMap.channel),sheenRoughnessMapUv:et&&d(_.sheenRoughnessMap.channel),specularMapUv:it&&d(_.specularMap.channel),specularColorMapUv:pt&&d(_.specularColorMap.channel),specularIntensityMapUv:U&&d(_.specularIntensityMap.channel),transmissionMapUv:rt&&d(_.transmissionMap.channel),thicknessMapUv:nt&&d(_.thicknessMap.channel),alphaMapUv:gt&&d(_.alphaMap.channel),vertexTangents:!!N.attributes.tangent&&(Le||ln),vertexNormals:!!N.attributes.normal,vertexColors:_.vertexColors,vertexAlphas:_.vertexColors===!0&&!!N.attributes.color&&N.attributes.color.itemSize===4,pointsUvs:L.isPoints===!0&&!!N.attributes.uv&&(Vt||gt),fog:!!G,useFog:_.fog===!0,fogExp2:!!G&&G.isFogExp2,flatShading:_.wireframe===!1&&(_.flatShading===!0||N.attributes.normal===void 0&&Le===!1&&(_.isMeshLambertMaterial||_.isMeshPhongMaterial||_.isMeshStandardMaterial||_.isMeshPhysicalMaterial)),sizeAttenuation:_.sizeAttenuation===!0,logarithmicDepthBuffer:f,reversedDepthBuffer:St,skinning:L.isSkinnedMesh===!0,hasPositionAttribute:N.attributes.position!==void 0,morphTargets:N.morphAttributes.position!==void 0,morphNormals:N.morphAttributes.normal!==void 0,morphColors:N.morphAttributes.color!==void 0,morphTargetsCount:st,morphTextureStride:ft,numSunLights:E.sun.length,numDirLights:E.directional.length,numPointLights:E.point.length,numSpotLights:E.spot.length,numSpotLightMaps:E.spotLightMap.length,numRectAreaLights:E.rectArea.length,numHemiLights:E.hemi.length,numSunLightShadows:E.sunShadowMap.length,numDirLightShadows:E.directionalShadowMap.length,numPointLightShadows:E.pointShadowMap.length,numSpotLightShadows:E.spotShadowMap.length,numSpotLightShadowsWithMaps:E.numSpotLightShadowsWithMaps,numLightProbes:E.numLightProbes,numLightProbeGrids:H.filter(Rt=>Rt.texture!==null).length,numClippingPlanes:r.numPlanes,numClipIntersection:r.numIntersection,dithering:_.dithering,shadowMapEnabled:i.shadowMap.enabled&&V.length>0,shadowMapType:i.shadowMap.type,toneMapping:lt,decodeVideoTexture:Vt&&_.map.isVideoTexture===!0&&ge.getTransfer(_.map.colorSpace)===Re,decodeVideoTextureEmissive:be&&_.emissiveMap.isVideoTexture===!0&&ge.getTransfer(_.emissiveMap.colorSpace)===Re,premultipliedAlpha:_.premultipliedAlpha,doubleSided:_.side===On,flipSided:_.side===Kn,useDepthPacking:_.depthPacking>=0,depthPacking:_.depthPacking||0,index0AttributeName:_.index0AttributeName,extensionClipCullDistance:Qt&&_.extensions.clipCullDistance===!0&&e.has("WEBGL_clip_cull_distance"),extensionMultiDraw:(Qt&&_.extensions.multiDraw===!0||oe)&&e.has("WEBGL_multi_draw"),rendererExtensionParallelShaderCompile:e.has("KHR_parallel_shader_compile"),customProgramCacheKey:_.customProgramCacheKey()};return te.vertexUv1s=l.has(1),te.vertexUv2s=l.has(2),te.vertexUv3s=l.has(3),l.clear(),te}function M(_){let E=[];if(_.shaderID?E.push(_.shaderID):(E.push(_.customVertexShaderID),E.push(_.customFragmentShaderID)),_.defines!==void 0)for(let V in _.defines)E.push(V),E.push(_.defines[V]);return _.isRawShaderMaterial===!1&&(m(E,_),p(E,_),E.push(i.outputColorSpace)),E.push(_.customProgramCacheKey),E.join()}function m(_,E){_.push(E.precision),_.push(E.outputColorSpace),_.push(E.envMapMode),_.push(E.envMapPMREM),_.push(E.envMapMaxLod),_.push(E.envMapSize),_.push(E.mapUv),_.push(E.alphaMapUv),_.push(E.lightMapUv),_.push(E.aoMapUv),_.push(E.bumpMapUv),_.push(E.normalMapUv),_.push(E.displacementMapUv),_.push(E.emissiveMapUv),_.push(E.metalnessMapUv),_.push(E.roughnessMapUv),_.push(E.anisotropyMapUv),_.push(E.clearcoatMapUv),_.push(E.clearcoatNormalMapUv),_.push(E.clearcoatRoughnessMapUv),_.push(E.diffuseRoughnessMapUv),_.push(E.iridescenceMapUv),_.push(E.iridescenceThicknessMapUv),_.push(E.sheenColorMapUv),_.push(E.sheenRoughnessMapUv),_.push(E.specularMapUv),_.push(E.specularColorMapUv),_.push(E.specularIntensityMapUv),_.push(E.transmissionMapUv),_.push(E.thicknessMapUv),_.push(E.combine),_.push(E.fogExp2),_.push(E.sizeAttenuation),_.push(E.morphTargetsCount),_.push(E.numSunLights),_.push(E.numDirLights),_.push(E.numPointLights),_.push(E.numSpotLights),_.push(E.numSpotLightMaps),_.push(E.numHemiLights),_.push(E.numRectAreaLights),_.push(E.numSunLightShadows),_.push(E.numDirLightShadows),_.push(E.numPointLightShadows),_.push(E.numSpotLightShadows),_.push(E.numSpotLightShadowsWithMaps),_.push(E.numLightProbes),_.push(E.numLightProbeGrids),_.push(E.shadowMapType),_.push(E.toneMapping),_.push(E.numClippingPlanes),_.push(E.numClipIntersection),_.push(E.depthPacking)}function p(_,E){o.disableAll(),E.instancing&&o.enable(0),E.instancingColor&&o.enable(1),E.instancingMorph&&o.enable(2),E.matcap&&o.enable(3),E.envMap&&o.enable(4),E.normalMapObjectSpace&&o.enable(5),E.normalMapTangentSpace&&o.enable(6),E.clearcoat&&o.enable(7),E.iridescence&&o.enable(8),E.alphaTest&&o.enable(9),E.vertexColors&&o.enable(10),E.vertexAlphas&&o.enable(11),E.vertexUv1s&&o.enable(12),E.vertexUv2s&&o.enable(13),E.vertexUv3s&&o.enable(14),E.vertexTangents&&o.enable(15),E.anisotropy&&o.enable(16),E.alphaHash&&o.enable(17),E.batching&&o.enable(18),E.dispersion&&o.enable(19),E.retroreflection&&o.enable(24),E.diffuseRoughness&&o.enable(25),E.batchingColor&&o.enable(20),E.gradientMap&&o.enable(21),E.packedNormalMap&&o.enable(22),E.vertexNormals&&o.enable(23),_.push(o.mask),o.disableAll(),E.fog&&o.enable(0),E.useFog&&o.enable(1),E.flatShading&&o.enable(2),E.logarithmicDepthBuffer&&o.enable(3),E.reversedDepthBuffer&&o.enable(4),E.skinning&&o.enable(5),E.morphTargets&&o.enable(6),E.morphNormals&&o.enable(7),E.morphColors&&o.enable(8),E.premultipliedAlpha&&o.enable(9),E.shadowMapEnabled&&o.enable(10),E.doubleSided&&o.enable(11),E.flipSided&&o.enable(12),E.useDepthPacking&&o.enable(13),E.dithering&&o.enable(14),E.transmission&&o.enable(15),E.sheen&&o.enable(16),E.opaque&&o.enable(17),E.pointsUvs&&o.enable(18),E.decodeVideoTexture&&o.enable(19),E.decodeVideoTextureEmissive&&o.enable(20),E.alphaToCoverage&&o.enable(21),E.numLightProbeGrids>0&&o.enable(22),E.hasPositionAttribute&&o.enable(23),_.push(o.mask)}function y(_){let E=u[_.type],V;if(E){let D=ts[E];V=w0.clone(D.uniforms)}else V=_.uniforms;return V}function A(_,E){let V=h.get(E);return V!==void 0?++V.usedTimes:(V=new SE(i,E,_,s),c.push(V),h.set(E,V)),V}function w(_){if(--_.usedTimes===0){let E=c.indexOf(_);c[E]=c[c.length-1],c.pop(),h.delete(_.cacheKey),_.destroy()}}function P(_){a.remove(_)}function T(){a.dispose()}return{getParameters:g,getProgramCacheKey:M,getUniforms:y,acquireProgram:A,releaseProgram:w,releaseShaderCache:P,programs:c,dispose:T}}function TE(){let i=new WeakMap;function t(o){return i.has(o)}function e(o){let a=i.get(o);return a===void 0&&(a={},i.set(o,a)),a}function n(o){i.delete(o)}function s(o,a,l){i.get(o)[a]=l}function r(){i=new WeakMap}return{has:t,get:e,remove:n,update:s,dispose:r}}function AE(i,t){return i.groupOrder!==t.groupOrder?i.groupOrder-t.groupOrder:i.renderOrder!==t.renderOrder?i.renderOrder-t.renderOrder:i.material.id!==t.material.id?i.material.id-t.material.id:i.materialVariant!==t.materialVariant?i.materialVariant-t.materialVariant:i.z!==t.z?i.z-t.z:i.id-t.id}function W0(i,t){return i.groupOrder!==t.groupOrder?i.groupOrder-t.groupOrder:i.renderOrder!==t.renderOrder?i.renderOrder-t.renderOrder:i.z!==t.z?t.z-i.z:i.id-t.id}function X0(){let i=[],t=0,e=[],n=[],s=[];function r(){t=0,e.length=0,n.length=0,s.length=0}function o(u){let d=0;return u.isInstancedMesh&&(d+=2),u.isSkinnedMesh&&(d+=1),d}function a(u,d,g,M,m,p){let y=i[t];return y===void 0?(y={id:u.id,object:u,geometry:d,material:g,materialVariant:o(u),groupOrder:M,renderOrder:u.renderOrder,z:m,group:p},i[t]=y):(y.id=u.id,y.object=u,y.geometry=d,y.material=g,y.materialVariant=o(u),y.groupOrder=M,y.renderOrder=u.renderOrder,y.z=m,y.group=p),t++,y}function l(u,d,g,M,m,p,y){y.reversedDepth===!0&&(m=-m);let A=a(u,d,g,M,m,p);g.transmission>0?n.push(A):g.transparent===!0?s.push(A):e.push(A)}function c(u,d,g,M,m,p){let y=a(u,d,g,M,m,p);g.transmission>0?n.unshift(y):g.transparent===!0?s.unshift(y):e.unshift(y)}function h(u,d){e.length>1&&e.sort(u||AE),n.length>1&&n.sort(d||W0),s.length>1&&s.sort(d||W0)}function f(){for(let u=t,d=i.length;u<d;u++){let g=i[u];if(g.id===null)break;g.id=null,g.object=null,g.geometry=null,g.material=null,g.group=null}}return{opaque:e,transmissive:n,transparent:s,init:r,push:l,unshift:c,finish:f,sort:h}}function RE(){let i=new WeakMap;function t(n,s){let r=i.get(n),o;return r===void 0?(o=new X0,i.set(n,[o])):s>=r.length?(o=new X0,r.push(o)):o=r[s],o}function e(){i=new WeakMap}return{get:t,dispose:e}}function CE(){let i={};return{get:function(t){if(i[t.id]!==void 0)return i[t.id];let e;switch(t.type){case"SunLight":case"DirectionalLight":e={direction:new q,color:new Yt};break;case"SpotLight":e={position:new q,direction:new q,color:new Yt,distance:0,coneCos:0,penumbraCos:0,decay:0};break;case"PointLight":e={position:new q,color:new Yt,distance:0,decay:0};break;case"HemisphereLight":e={direction:new q,skyColor:new Yt,groundColor:new Yt};break;case"RectAreaLight":e={color:new Yt,position:new q,halfWidth:new q,halfHeight:new q};break}return i[t.id]=e,e}}}function PE(){let i={};return{get:function(t){if(i[t.id]!==void 0)return i[t.id];let e;switch(t.type){case"SunLight":case"DirectionalLight":e={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new Jt};break;case"SpotLight":e={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new Jt};break;case"PointLight":e={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new Jt,shadowCameraNear:1,shadowCameraFar:1e3};break}return i[t.id]=e,e}}}var IE=0;function LE(i,t){return(t.castShadow?2:0)-(i.castShadow?2:0)+(t.map?1:0)-(i.map?1:0)}function NE(i){let t=new CE,e=PE(),n={version:0,hash:{sunLength:-1,directionalLength:-1,pointLength:-1,spotLength:-1,rectAreaLength:-1,hemiLength:-1,numSunShadows:-1,numDirectionalShadows:-1,numPointShadows:-1,numSpotShadows:-1,numSpotMaps:-1,numLightProbes:-1},ambient:[0,0,0],probe:[],sun:[],sunShadow:[],sunShadowMap:[],sunShadowMatrix:[],sunShadowCascade:[],directional:[],directionalShadow:[],directionalShadowMap:[],directionalShadowMatrix:[],spot:[],spotLightMap:[],spotShadow:[],spotShadowMap:[],spotLightMatrix:[],rectArea:[],rectAreaLTC1:null,rectAreaLTC2:null,point:[],pointShadow:[],pointShadowMap:[],pointShadowMatrix:[],hemi:[],numSpotLightShadowsWithMaps:0,numLightProbes:0};for(let c=0;c<9;c++)n.probe.push(new q);let s=new q,r=new Ke,o=new Ke;function a(c){let h=0,f=0,u=0;for(let H=0;H<9;H++)n.probe[H].set(0,0,0);let d=0,g=0,M=0,m=0,p=0,y=0,A=0,w=0,P=0,T=0,_=0,E=0,V=0,D=0;c.sort(LE);for(let H=0,G=c.length;H<G;H++){let N=c[H],z=N.color,J=N.intensity,k=N.distance,ct=null;if(N.shadow&&N.shadow.map&&(N.shadow.map.texture.format===Ys?ct=N.shadow.map.texture:ct=N.shadow.map.depthTexture||N.shadow.map.texture),N.isAmbientLight)h+=z.r*J,f+=z.g*J,u+=z.b*J;else if(N.isLightProbe){for(let K=0;K<9;K++)n.probe[K].addScaledVector(N.sh.coefficients[K],J);D++}else if(N.isSunLight){let K=t.get(N);if(K.color.copy(N.color).multiplyScalar(N.intensity),N.castShadow){let Q=N.shadow,st=e.get(N);st.shadowIntensity=Q.intensity,st.shadowBias=Q.bias,st.shadowNormalBias=Q.normalBias,st.shadowRadius=Q.radius,st.shadowMapSize.copy(Q.mapSize).multiply(Q.getFrameExtents()),n.sunShadow[g]=st,n.sunShadowMap[g]=ct;let ft=Q.getViewportCount();for(let ut=0;ut<ft;ut++)n.sunShadowMatrix[M+ut]=Q.getMatrix(ut),n.sunShadowCascade[M+ut]=Q._cascadeData[ut];M+=ft,g++}n.sun[d]=K,d++}else if(N.isDirectionalLight){let K=t.get(N);if(K.color.copy(N.color).multiplyScalar(N.intensity),N.castShadow){let Q=N.shadow,st=e.get(N);st.shadowIntensity=Q.intensity,st.shadowBias=Q.bias,st.shadowNormalBias=Q.normalBias,st.shadowRadius=Q.radius,st.shadowMapSize=Q.mapSize,n.directionalShadow[m]=st,n.directionalShadowMap[m]=ct,n.directionalShadowMatrix[m]=N.shadow.matrix,P++}n.directional[m]=K,m++}else if(N.isSpotLight){let K=t.get(N);K.position.setFromMatrixPosition(N.matrixWorld),K.color.copy(z).multiplyScalar(J),K.distance=k,K.coneCos=Math.cos(N.angle),K.penumbraCos=Math.cos(N.angle*(1-N.penumbra)),K.decay=N.decay,n.spot[y]=K;let Q=N.shadow;if(N.map&&(n.spotLightMap[E]=N.map,E++,Q.updateMatrices(N),N.castShadow&&V++),n.spotLightMatrix[y]=Q.matrix,N.castShadow){let st=e.get(N);st.shadowIntensity=Q.intensity,st.shadowBias=Q.bias,st.shadowNormalBias=Q.normalBias,st.shadowRadius=Q.radius,st.shadowMapSize=Q.mapSize,n.spotShadow[y]=st,n.spotShadowMap[y]=ct,_++}y++}else if(N.isRectAreaLight){let K=t.get(N);K.color.copy(z).multiplyScalar(J),K.halfWidth.set(N.width*.5,0,0),K.halfHeight.set(0,N.height*.5,0),n.rectArea[A]=K,A++}else if(N.isPointLight){let K=t.get(N);if(K.color.copy(N.color).multiplyScalar(N.intensity),K.distance=N.distance,K.decay=N.decay,N.castShadow){let Q=N.shadow,st=e.get(N);st.shadowIntensity=Q.intensity,st.shadowBias=Q.bias,st.shadowNormalBias=Q.normalBias,st.shadowRadius=Q.radius,st.shadowMapSize=Q.mapSize,st.shadowCameraNear=Q.camera.near,st.shadowCameraFar=Q.camera.far,n.pointShadow[p]=st,n.pointShadowMap[p]=ct,n.pointShadowMatrix[p]=N.shadow.matrix,T++}n.point[p]=K,p++}else if(N.isHemisphereLight){let K=t.get(N);K.skyColor.copy(N.color).multiplyScalar(J),K.groundColor.copy(N.groundColor).multiplyScalar(J),n.hemi[w]=K,w++}}A>0&&(i.has("OES_texture_float_linear")===!0?(n.rectAreaLTC1=Lt.LTC_FLOAT_1,n.rectAreaLTC2=Lt.LTC_FLOAT_2):(n.rectAreaLTC1=Lt.LTC_HALF_1,n.rectAreaLTC2=Lt.LTC_HALF_2)),n.ambient[0]=h,n.ambient[1]=f,n.ambient[2]=u;let L=n.hash;(L.sunLength!==d||L.directionalLength!==m||L.pointLength!==p||L.spotLength!==y||L.rectAreaLength!==A||L.hemiLength!==w||L.numSunShadows!==g||L.numDirectionalShadows!==P||L.numPointShadows!==T||L.numSpotShadows!==_||L.numSpotMaps!==E||L.numLightProbes!==D)&&(n.sun.length=d,n.directional.length=m,n.spot.length=y,n.rectArea.length=A,n.point.length=p,n.hemi.length=w,n.sunShadow.length=g,n.sunShadowMap.length=g,n.sunShadowMatrix.length=M,n.sunShadowCascade.length=M,n.directionalShadow.length=P,n.directionalShadowMap.length=P,n.directionalShadowMatrix.length=P,n.pointShadow.length=T,n.pointShadowMap.length=T,n.pointShadowMatrix.length=T,n.spotShadow.length=_,n.spotShadowMap.length=_,n.spotLightMatrix.length=_+E-V,n.spotLightMap.length=E,n.numSpotLightShadowsWithMaps=V,n.numLightProbes=D,L.sunLength=d,L.directionalLength=m,L.pointLength=p,L.spotLength=y,L.rectAreaLength=A,L.hemiLength=w,L.numSunShadows=g,L.numDirectionalShadows=P,L.numPointShadows=T,L.numSpotShadows=_,L.numSpotMaps=E,L.numLightProbes=D,n.version=IE++)}function l(c,h){let f=0,u=0,d=0,g=0,M=0,m=0,p=h.matrixWorldInverse;for(let y=0,A=c.length;y<A;y++){let w=c[y];if(w.isSunLight){let P=n.sun[f];P.direction.setFromMatrixPosition(w.matrixWorld),P.direction.transformDirection(p),f++}else if(w.isDirectionalLight){let P=n.directional[u];P.direction.setFromMatrixPosition(w.matrixWorld),s.setFromMatrixPosition(w.target.matrixWorld),P.direction.sub(s),P.direction.transformDirection(p),u++}else if(w.isSpotLight){let P=n.spot[g];P.position.setFromMatrixPosition(w.matrixWorld),P.position.applyMatrix4(p),P.direction.setFromMatrixPosition(w.matrixWorld),s.setFromMatrixPosition(w.target.matrixWorld),P.direction.sub(s),P.direction.transformDirection(p),g++}else if(w.isRectAreaLight){let P=n.rectArea[M];P.position.setFromMatrixPosition(w.matrixWorld),P.position.applyMatrix4(p),o.identity(),r.copy(w.matrixWorld),r.premultiply(p),o.extractRotation(r),P.halfWidth.set(w.width*.5,0,0),P.halfHeight.set(0,w.height*.5,0),P.halfWidth.applyMatrix4(o),P.halfHeight.applyMatrix4(o),M++}else if(w.isPointLight){let P=n.point[d];P.position.setFromMatrixPosition(w.matrixWorld),P.position.applyMatrix4(p),d++}else if(w.isHemisphereLight){let P=n.hemi[m];P.direction.setFromMatrixPosition(w.matrixWorld),P.direction.transformDirection(p),m++}}}return{setup:a,setupView:l,state:n}}function q0(i){let t=new NE(i),e=[],n=[],s=[];function r(f){h.camera=f,e.length=0,n.length=0,s.length=0}function o(f){f.isLightProbeGrid?s.push(f):e.push(f)}function a(f){n.push(f)}function l(){t.setup(e),s.sort((f,u)=>f.priority-u.priority||f.id-u.id)}function c(f){t.setupView(e,f)}let h={lightsArray:e,shadowsArray:n,lightProbeGridArray:s,camera:null,lights:t,transmissionRenderTarget:{},textureUnits:0};return{init:r,state:h,setupLights:l,setupLightsView:c,pushLight:o,pushShadow:a}}function DE(i){let t=new WeakMap;function e(s,r=0){let o=t.get(s),a;return o===void 0?(a=new q0(i),t.set(s,[a])):r>=o.length?(a=new q0(i),o.push(a)):a=o[r],a}function n(){t=new WeakMap}return{get:e,dispose:n}}var UE=`void main() {
	gl_Position = vec4( position, 1.0 );
}`,FE=`uniform sampler2D shadow_pass;
uniform vec2 resolution;
uniform float radius;
void main() {
	const float samples = float( VSM_SAMPLES );
	float mean = 0.0;
	float squared_mean = 0.0;
	float uvStride = samples <= 1.0 ? 0.0 : 2.0 / ( samples - 1.0 );
	float uvStart = samples <= 1.0 ? 0.0 : - 1.0;
	for ( float i = 0.0; i < samples; i ++ ) {
		float uvOffset = uvStart + i * uvStride;
		#ifdef HORIZONTAL_PASS
			vec2 distribution = texture2D( shadow_pass, ( gl_FragCoord.xy + vec2( uvOffset, 0.0 ) * radius ) / resolution ).rg;
			mean += distribution.x;
			squared_mean += distribution.y * distribution.y + distribution.x * distribution.x;
		#else
			float depth = texture2D( shadow_pass, ( gl_FragCoord.xy + vec2( 0.0, uvOffset ) * radius ) / resolution ).r;
			mean += depth;
			squared_mean += depth * depth;
		#endif
	}
	mean = mean / samples;
	squared_mean = squared_mean / samples;
	float std_dev = sqrt( max( 0.0, squared_mean - mean * mean ) );
	gl_FragColor = vec4( mean, std_dev, 0.0, 1.0 );
}`,OE=[new q(1,0,0),new q(-1,0,0),new q(0,1,0),new q(0,-1,0),new q(0,0,1),new q(0,0,-1)],BE=[new q(0,-1,0),new q(0,-1,0),new q(0,0,1),new q(0,0,-1),new q(0,-1,0),new q(0,-1,0)],$0=new Ke,Ta=new q,hd=new q;function kE(i,t,e){let n=new gr,s=new Jt,r=new Jt,o=new qe,a=new gc,l=new xc,c={},h=e.maxTextureSize,f={[$s]:Kn,[Kn]:$s,[On]:On},u=new mn({defines:{VSM_SAMPLES:8},uniforms:{shadow_pass:{value:null},resolution:{value:new Jt},radius:{value:4}},vertexShader:UE,fragmentShader:FE}),d=u.clone();d.defines.HORIZONTAL_PASS=1;let g=new Fn;g.setAttribute("position",new De(new Float32Array([-1,-1,.5,3,-1,.5,-1,3,.5]),3));let M=new Cn(g,u),m=this;this.enabled=!1,this.autoUpdate=!0,this.needsUpdate=!1,this.type=xa;let p=this.type;this.render=function(T,_,E){if(m.enabled===!1||m.autoUpdate===!1&&m.needsUpdate===!1||T.length===0)return;this.type===Hg&&(jt("WebGLShadowMap: PCFSoftShadowMap has been removed. Using PCFShadowMap instead."),this.type=xa);let V=i.getRenderTarget(),D=i.getActiveCubeFace(),L=i.getActiveMipmapLevel(),H=i.state;H.setBlending(vr),H.buffers.depth.getReversed()===!0?H.buffers.color.setClear(0,0,0,0):H.buffers.color.setClear(1,1,1,1),H.buffers.depth.setTest(!0),H.setScissorTest(!1);let G=p!==this.type;G&&_.traverse(function(N){N.material&&(Array.isArray(N.material)?N.material.forEach(z=>z.needsUpdate=!0):N.material.needsUpdate=!0)});for(let N=0,z=T.length;N<z;N++){let J=T[N],k=J.shadow;if(k===void 0){jt("WebGLShadowMap:",J,"has no shadow.");continue}if(k.autoUpdate===!1&&k.needsUpdate===!1)continue;s.copy(k.mapSize);let ct=k.getFrameExtents();s.multiply(ct),r.copy(k.mapSize),(s.x>h||s.y>h)&&(s.x>h&&(r.x=Math.floor(h/ct.x),s.x=r.x*ct.x,k.mapSize.x=r.x),s.y>h&&(r.y=Math.floor(h/ct.y),s.y=r.y*ct.y,k.mapSize.y=r.y));let K=i.state.buffers.depth.getReversed();if(k.camera._reversedDepth=K,k.map===null||G===!0){if(k.map!==null&&(k.map.depthTexture!==null&&(k.map.depthTexture.dispose(),k.map.depthTexture=null),k.map.dispose()),this.type===vo){if(J.isPointLight){jt("WebGLShadowMap: VSM shadow maps are not supported for PointLights. Use PCF or BasicShadowMap instead.");continue}k.map=new ci(s.x,s.y,{format:Ys,type:Di,minFilter:Zn,magFilter:Zn,generateMipmaps:!1}),k.map.texture.name=J.name+".shadowMap",k.map.depthTexture=new gs(s.x,s.y,Ni),k.map.depthTexture.name=J.name+".shadowMapDepth",k.map.depthTexture.format=ms,k.map.depthTexture.compareFunction=null,k.map.depthTexture.minFilter=on,k.map.depthTexture.magFilter=on}else J.isPointLight?(k.map=new Ra(s.x),k.map.depthTexture=new ua(s.x,Li)):(k.map=new ci(s.x,s.y),k.map.depthTexture=new gs(s.x,s.y,Li)),k.map.depthTexture.name=J.name+".shadowMap",k.map.depthTexture.format=ms,this.type===xa?(k.map.depthTexture.compareFunction=K?ed:td,k.map.depthTexture.minFilter=Zn,k.map.depthTexture.magFilter=Zn):(k.map.depthTexture.compareFunction=null,k.map.depthTexture.minFilter=on,k.map.depthTexture.magFilter=on);k.camera.updateProjectionMatrix()}k.map.isWebGLCubeRenderTarget!==!0&&(k.map.width!==s.x||k.map.height!==s.y)&&k.map.setSize(s.x,s.y);let Q=k.map.isWebGLCubeRenderTarget?6:k.getViewportCount();J.isPointLight!==!0&&k.updateMatrices(J,E);let st=(k.camera.layers.mask&4294967294)!==0?k.camera.layers:E.layers;for(let ft=0;ft<Q;ft++){let ut=k.getCamera(ft);if(J.isPointLight){let tt=k.camera,mt=k.matrix,_t=J.distance||tt.far;_t!==tt.far&&(tt.far=_t,tt.updateProjectionMatrix()),Ta.setFromMatrixPosition(J.matrixWorld),tt.position.copy(Ta),hd.copy(tt.position),hd.add(OE[ft]),tt.up.copy(BE[ft]),tt.lookAt(hd),tt.updateMatrixWorld(),mt.makeTranslation(-Ta.x,-Ta.y,-Ta.z),$0.multiplyMatrices(tt.projectionMatrix,tt.matrixWorldInverse),k._frustum.setFromProjectionMatrix($0,tt.coordinateSystem,tt.reversedDepth)}if(k.map.isWebGLCubeRenderTarget)i.setRenderTarget(k.map,ft),i.clear();else{ft===0&&(i.setRenderTarget(k.map),i.clear());let tt=k.getViewport(ft);o.set(r.x*tt.x,r.y*tt.y,r.x*tt.z,r.y*tt.w),H.viewport(o)}n=k.getFrustum(ft),w(_,E,ut,J,st,this.type)}k.isPointLightShadow!==!0&&this.type===vo&&y(k,E),k.needsUpdate=!1}p=this.type,m.needsUpdate=!1,i.setRenderTarget(V,D,L)};function y(T,_){let E=t.update(M);u.defines.VSM_SAMPLES!==T.blurSamples&&(u.defines.VSM_SAMPLES=T.blurSamples,d.defines.VSM_SAMPLES=T.blurSamples,u.needsUpdate=!0,d.needsUpdate=!0),T.mapPass===null?T.mapPass=new ci(s.x,s.y,{format:Ys,type:Di}):(T.mapPass.width!==T.map.width||T.mapPass.height!==T.map.height)&&T.mapPass.setSize(T.map.width,T.map.height),u.uniforms.shadow_pass.value=T.map.depthTexture,u.uniforms.resolution.value.set(T.map.width,T.map.height),u.uniforms.radius.value=T.radius,i.setRenderTarget(T.mapPass),i.clear(),i.renderBufferDirect(_,null,E,u,M,null),d.uniforms.shadow_pass.value=T.mapPass.texture,d.uniforms.resolution.value.set(T.map.width,T.map.height),d.uniforms.radius.value=T.radius,i.setRenderTarget(T.map),i.clear(),i.renderBufferDirect(_,null,E,d,M,null)}function A(T,_,E,V){let D=null,L=E.isPointLight===!0?T.customDistanceMaterial:T.customDepthMaterial;if(L!==void 0)D=L;else if(D=E.isPointLight===!0?l:a,i.localClippingEnabled&&_.clipShadows===!0&&Array.isArray(_.clippingPlanes)&&_.clippingPlanes.length!==0||_.displacementMap&&_.displacementScale!==0||_.alphaMap&&_.alphaTest>0||_.map&&_.alphaTest>0||_.alphaToCoverage===!0){let H=D.uuid,G=_.uuid,N=c[H];N===void 0&&(N={},c[H]=N);let z=N[G];z===void 0&&(z=D.clone(),N[G]=z,_.addEventListener("dispose",P)),D=z}if(D.visible=_.visible,D.wireframe=_.wireframe,V===vo?D.side=_.shadowSide!==null?_.shadowSide:_.side:D.side=_.shadowSide!==null?_.shadowSide:f[_.side],D.alphaMap=_.alphaMap,D.alphaTest=_.alphaToCoverage===!0?.5:_.alphaTest,D.map=_.map,D.clipShadows=_.clipShadows,D.clippingPlanes=_.clippingPlanes,D.clipIntersection=_.clipIntersection,D.displacementMap=_.displacementMap,D.displacementScale=_.displacementScale,D.displacementBias=_.displacementBias,D.wireframeLinewidth=_.wireframeLinewidth,D.linewidth=_.linewidth,E.isPointLight===!0&&D.isMeshDistanceMaterial===!0){let H=i.properties.get(D);H.light=E}return D}function w(T,_,E,V,D,L){if(T.visible===!1)return;if(T.layers.test(D)&&(T.isMesh||T.isLine||T.isPoints)&&(T.castShadow||T.receiveShadow&&L===vo)&&(!T.frustumCulled||T.intersectsFrustum(n))){T.modelViewMatrix.multiplyMatrices(E.matrixWorldInverse,T.matrixWorld);let N=t.update(T),z=T.material;if(Array.isArray(z)){let J=N.groups;for(let k=0,ct=J.length;k<ct;k++){let K=J[k],Q=z[K.materialIndex];if(Q&&Q.visible){let st=A(T,Q,V,L);T.onBeforeShadow(i,T,_,E,N,st,K),i.renderBufferDirect(E,null,N,st,T,K),T.onAfterShadow(i,T,_,E,N,st,K)}}}else if(z.visible){let J=A(T,z,V,L);T.onBeforeShadow(i,T,_,E,N,J,null),i.renderBufferDirect(E,null,N,J,T,null),T.onAfterShadow(i,T,_,E,N,J,null)}}let G=T.children;for(let N=0,z=G.length;N<z;N++)w(G[N],_,E,V,D,L)}function P(T){T.target.removeEventListener("dispose",P);for(let E in c){let V=c[E],D=T.target.uuid;D in V&&(V[D].dispose(),delete V[D])}}}function zE(i,t){function e(){let U=!1,rt=new qe,nt=null,wt=new qe(0,0,0,0);return{setMask:function(gt){nt!==gt&&!U&&(i.colorMask(gt,gt,gt,gt),nt=gt)},setLocked:function(gt){U=gt},setClear:function(gt,bt,Ht,Qt,lt){lt===!0&&(gt*=Qt,bt*=Qt,Ht*=Qt),rt.set(gt,bt,Ht,Qt),wt.equals(rt)===!1&&(i.clearColor(gt,bt,Ht,Qt),wt.copy(rt))},reset:function(){U=!1,nt=null,wt.set(-1,0,0,0)}}}function n(){let U=!1,rt=!1,nt=null,wt=null,gt=null;return{setReversed:function(bt){if(rt!==bt){let Ht=t.get("EXT_clip_control");bt?Ht.clipControlEXT(Ht.LOWER_LEFT_EXT,Ht.ZERO_TO_ONE_EXT):Ht.clipControlEXT(Ht.LOWER_LEFT_EXT,Ht.NEGATIVE_ONE_TO_ONE_EXT),rt=bt;let Qt=gt;gt=null,this.setClear(Qt)}},getReversed:function(){return rt},setTest:function(bt){bt?St(i.DEPTH_TEST):Wt(i.DEPTH_TEST)},setMask:function(bt){nt!==bt&&!U&&(i.depthMask(bt),nt=bt)},setFunc:function(bt){if(rt&&(bt=v0[bt]),wt!==bt){switch(bt){case Kl:i.depthFunc(i.NEVER);break;case jl:i.depthFunc(i.ALWAYS);break;case Ql:i.depthFunc(i.LESS);break;case uo:i.depthFunc(i.LEQUAL);break;case tc:i.depthFunc(i.EQUAL);break;case ec:i.depthFunc(i.GEQUAL);break;case nc:i.depthFunc(i.GREATER);break;case ic:i.depthFunc(i.NOTEQUAL);break;default:i.depthFunc(i.LEQUAL)}wt=bt}},setLocked:function(bt){U=bt},setClear:function(bt){gt!==bt&&(gt=bt,rt&&(bt=1-bt),i.clearDepth(bt))},reset:function(){U=!1,nt=null,wt=null,gt=null,rt=!1}}}function s(){let U=!1,rt=null,nt=null,wt=null,gt=null,bt=null,Ht=null,Qt=null,lt=null;return{setTest:function(Ot){U||(Ot?St(i.STENCIL_TEST):Wt(i.STENCIL_TEST))},setMask:function(Ot){rt!==Ot&&!U&&(i.stencilMask(Ot),rt=Ot)},setFunc:function(Ot,te,Rt){(nt!==Ot||wt!==te||gt!==Rt)&&(i.stencilFunc(Ot,te,Rt),nt=Ot,wt=te,gt=Rt)},setOp:function(Ot,te,Rt){(bt!==Ot||Ht!==te||Qt!==Rt)&&(i.stencilOp(Ot,te,Rt),bt=Ot,Ht=te,Qt=Rt)},setLocked:function(Ot){U=Ot},setClear:function(Ot){lt!==Ot&&(i.clearStencil(Ot),lt=Ot)},reset:function(){U=!1,rt=null,nt=null,wt=null,gt=null,bt=null,Ht=null,Qt=null,lt=null}}}let r=new e,o=new n,a=new s,l={},c=new WeakMap,h={},f={},u={},d=new WeakMap,g=[],M=null,m=!1,p=null,y=null,A=null,w=null,P=null,T=null,_=null,E=new Yt(0,0,0),V=0,D=!1,L=null,H=null,G=null,N=null,z=null,J=i.getParameter(i.MAX_COMBINED_TEXTURE_IMAGE_UNITS),k=!1,ct=0,K=i.getParameter(i.VERSION);K.indexOf("WebGL")!==-1?(ct=parseFloat(/^WebGL (\d)/.exec(K)[1]),k=ct>=1):K.indexOf("OpenGL ES")!==-1&&(ct=parseFloat(/^OpenGL ES (\d)/.exec(K)[1]),k=ct>=2);let Q=null,st={},ft=i.getParameter(i.SCISSOR_BOX),ut=i.getParameter(i.VIEWPORT),tt=new qe().fromArray(ft),mt=new qe().fromArray(ut);function _t(U,rt,nt,wt){let gt=new Uint8Array(4),bt=i.createTexture();i.bindTexture(U,bt),i.texParameteri(U,i.TEXTURE_MIN_FILTER,i.NEAREST),i.texParameteri(U,i.TEXTURE_MAG_FILTER,i.NEAREST);for(let Ht=0;Ht<nt;Ht++)U===i.TEXTURE_3D||U===i.TEXTURE_2D_ARRAY?i.texImage3D(rt,0,i.RGBA,1,1,wt,0,i.RGBA,i.UNSIGNED_BYTE,gt):i.texImage2D(rt+Ht,0,i.RGBA,1,1,0,i.RGBA,i.UNSIGNED_BYTE,gt);return bt}let At={};At[i.TEXTURE_2D]=_t(i.TEXTURE_2D,i.TEXTURE_2D,1),At[i.TEXTURE_CUBE_MAP]=_t(i.TEXTURE_CUBE_MAP,i.TEXTURE_CUBE_MAP_POSITIVE_X,6),At[i.TEXTURE_2D_ARRAY]=_t(i.TEXTURE_2D_ARRAY,i.TEXTURE_2D_ARRAY,1,1),At[i.TEXTURE_3D]=_t(i.TEXTURE_3D,i.TEXTURE_3D,1,1),r.setClear(0,0,0,1),o.setClear(1),a.setClear(0),St(i.DEPTH_TEST),o.setFunc(uo),an(!1),Le(Lf),St(i.CULL_FACE),$e(vr);function St(U){h[U]!==!0&&(i.enable(U),h[U]=!0)}function Wt(U){h[U]!==!1&&(i.disable(U),h[U]=!1)}function oe(U,rt){return u[U]!==rt?(i.bindFramebuffer(U,rt),u[U]=rt,U===i.DRAW_FRAMEBUFFER&&(u[i.FRAMEBUFFER]=rt),U===i.FRAMEBUFFER&&(u[i.DRAW_FRAMEBUFFER]=rt),!0):!1}function Vt(U,rt){let nt=g,wt=!1;if(U){nt=d.get(rt),nt===void 0&&(nt=[],d.set(rt,nt));let gt=U.textures;if(nt.length!==gt.length||nt[0]!==i.COLOR_ATTACHMENT0){for(let bt=0,Ht=gt.length;bt<Ht;bt++)nt[bt]=i.COLOR_ATTACHMENT0+bt;nt.length=gt.length,wt=!0}}else nt[0]!==i.BACK&&(nt[0]=i.BACK,wt=!0);wt&&i.drawBuffers(nt)}function de(U){return M!==U?(i.useProgram(U),M=U,!0):!1}let he={[yr]:i.FUNC_ADD,[Gg]:i.FUNC_SUBTRACT,[Wg]:i.FUNC_REVERSE_SUBTRACT};he[Xg]=i.MIN,he[qg]=i.MAX;let se={[$g]:i.ZERO,[Ic]:i.ONE,[Yg]:i.SRC_COLOR,[Ff]:i.SRC_ALPHA,[t0]:i.SRC_ALPHA_SATURATE,[jg]:i.DST_COLOR,[Jg]:i.DST_ALPHA,[Zg]:i.ONE_MINUS_SRC_COLOR,[_a]:i.ONE_MINUS_SRC_ALPHA,[Qg]:i.ONE_MINUS_DST_COLOR,[Kg]:i.ONE_MINUS_DST_ALPHA,[e0]:i.CONSTANT_COLOR,[n0]:i.ONE_MINUS_CONSTANT_COLOR,[i0]:i.CONSTANT_ALPHA,[s0]:i.ONE_MINUS_CONSTANT_ALPHA};function $e(U,rt,nt,wt,gt,bt,Ht,Qt,lt,Ot){if(U===vr){m===!0&&(Wt(i.BLEND),m=!1);return}if(m===!1&&(St(i.BLEND),m=!0),U!==Pc){if(U!==p||Ot!==D){if((y!==yr||P!==yr)&&(i.blendEquation(i.FUNC_ADD),y=yr,P=yr),Ot)switch(U){case yo:i.blendFuncSeparate(i.ONE,i.ONE_MINUS_SRC_ALPHA,i.ONE,i.ONE_MINUS_SRC_ALPHA);break;case Nf:i.blendFunc(i.ONE,i.ONE);break;case Df:i.blendFuncSeparate(i.ZERO,i.ONE_MINUS_SRC_COLOR,i.ZERO,i.ONE);break;case Uf:i.blendFuncSeparate(i.DST_COLOR,i.ONE_MINUS_SRC_ALPHA,i.ZERO,i.ONE);break;default:ne("WebGLState: Invalid blending: ",U);break}else switch(U){case yo:i.blendFuncSeparate(i.SRC_ALPHA,i.ONE_MINUS_SRC_ALPHA,i.ONE,i.ONE_MINUS_SRC_ALPHA);break;case Nf:i.blendFuncSeparate(i.SRC_ALPHA,i.ONE,i.ONE,i.ONE);break;case Df:ne("WebGLState: SubtractiveBlending requires material.premultipliedAlpha = true");break;case Uf:ne("WebGLState: MultiplyBlending requires material.premultipliedAlpha = true");break;default:ne("WebGLState: Invalid blending: ",U);break}A=null,w=null,T=null,_=null,E.set(0,0,0),V=0,p=U,D=Ot}return}gt=gt||rt,bt=bt||nt,Ht=Ht||wt,(rt!==y||gt!==P)&&(i.blendEquationSeparate(he[rt],he[gt]),y=rt,P=gt),(nt!==A||wt!==w||bt!==T||Ht!==_)&&(i.blendFuncSeparate(se[nt],se[wt],se[bt],se[Ht]),A=nt,w=wt,T=bt,_=Ht),(Qt.equals(E)===!1||lt!==V)&&(i.blendColor(Qt.r,Qt.g,Qt.b,lt),E.copy(Qt),V=lt),p=U,D=!1}function Be(U,rt){U.side===On?Wt(i.CULL_FACE):St(i.CULL_FACE);let nt=U.side===Kn;rt&&(nt=!nt),an(nt),U.blending===yo&&U.transparent===!1?$e(vr):$e(U.blending,U.blendEquation,U.blendSrc,U.blendDst,U.blendEquationAlpha,U.blendSrcAlpha,U.blendDstAlpha,U.blendColor,U.blendAlpha,U.premultipliedAlpha),o.setFunc(U.depthFunc),o.setTest(U.depthTest),o.setMask(U.depthWrite),r.setMask(U.colorWrite);let wt=U.stencilWrite;a.setTest(wt),wt&&(a.setMask(U.stencilWriteMask),a.setFunc(U.stencilFunc,U.stencilRef,U.stencilFuncMask),a.setOp(U.stencilFail,U.stencilZFail,U.stencilZPass)),be(U.polygonOffset,U.polygonOffsetFactor,U.polygonOffsetUnits),U.alphaToCoverage===!0?St(i.SAMPLE_ALPHA_TO_COVERAGE):Wt(i.SAMPLE_ALPHA_TO_COVERAGE)}function an(U){L!==U&&(U?i.frontFace(i.CW):i.frontFace(i.CCW),L=U)}function Le(U){U!==zg?(St(i.CULL_FACE),U!==H&&(U===Lf?i.cullFace(i.BACK):U===Vg?i.cullFace(i.FRONT):i.cullFace(i.FRONT_AND_BACK))):Wt(i.CULL_FACE),H=U}function Sn(U){U!==G&&(k&&i.lineWidth(U),G=U)}function be(U,rt,nt){U?(St(i.POLYGON_OFFSET_FILL),(N!==rt||z!==nt)&&(N=rt,z=nt,o.getReversed()&&(rt=-rt,nt=-nt),i.polygonOffset(rt,nt))):Wt(i.POLYGON_OFFSET_FILL)}function gn(U){U?St(i.SCISSOR_TEST):Wt(i.SCISSOR_TEST)}function je(U){U===void 0&&(U=i.TEXTURE0+J-1),Q!==U&&(i.activeTexture(U),Q=U)}function ln(U,rt,nt){nt===void 0&&(Q===null?nt=i.TEXTURE0+J-1:nt=Q);let wt=st[nt];wt===void 0&&(wt={type:void 0,texture:void 0},st[nt]=wt),(wt.type!==U||wt.texture!==rt)&&(Q!==nt&&(i.activeTexture(nt),Q=nt),i.bindTexture(U,rt||At[U]),wt.type=U,wt.texture=rt)}function F(){let U=st[Q];U!==void 0&&U.type!==void 0&&(i.bindTexture(U.type,null),U.type=void 0,U.texture=void 0)}function Ct(){try{i.compressedTexImage2D(...arguments)}catch(U){ne("WebGLState:",U)}}function Zt(){try{i.compressedTexImage3D(...arguments)}catch(U){ne("WebGLState:",U)}}function ae(){try{i.texSubImage2D(...arguments)}catch(U){ne("WebGLState:",U)}}function Mt(){try{i.texSubImage3D(...arguments)}catch(U){ne("WebGLState:",U)}}function Ue(){try{i.compressedTexSubImage2D(...arguments)}catch(U){ne("WebGLState:",U)}}function zt(){try{i.compressedTexSubImage3D(...arguments)}catch(U){ne("WebGLState:",U)}}function $t(){try{i.texStorage2D(...arguments)}catch(U){ne("WebGLState:",U)}}function R(){try{i.texStorage3D(...arguments)}catch(U){ne("WebGLState:",U)}}function v(){try{i.texImage2D(...arguments)}catch(U){ne("WebGLState:",U)}}function W(){try{i.texImage3D(...arguments)}catch(U){ne("WebGLState:",U)}}function ht(U){return f[U]!==void 0?f[U]:i.getParameter(U)}function ot(U,rt){f[U]!==rt&&(i.pixelStorei(U,rt),f[U]=rt)}function xt(U){tt.equals(U)===!1&&(i.scissor(U.x,U.y,U.z,U.w),tt.copy(U))}function vt(U){mt.equals(U)===!1&&(i.viewport(U.x,U.y,U.z,U.w),mt.copy(U))}function et(U,rt){let nt=c.get(rt);nt===void 0&&(nt=new WeakMap,c.set(rt,nt));let wt=nt.get(U);wt===void 0&&(wt=i.getUniformBlockIndex(rt,U.name),i.uniformBlockBinding(rt,wt,wt),nt.set(U,wt))}function it(U,rt,nt){let gt=c.get(rt).get(U);l[gt]!==nt&&(i.bindBufferBase(i.UNIFORM_BUFFER,gt,nt),l[gt]=nt)}function pt(){i.disable(i.BLEND),i.disable(i.CULL_FACE),i.disable(i.DEPTH_TEST),i.disable(i.POLYGON_OFFSET_FILL),i.disable(i.SCISSOR_TEST),i.disable(i.STENCIL_TEST),i.disable(i.SAMPLE_ALPHA_TO_COVERAGE),i.blendEquation(i.FUNC_ADD),i.blendFunc(i.ONE,i.ZERO),i.blendFuncSeparate(i.ONE,i.ZERO,i.ONE,i.ZERO),i.blendColor(0,0,0,0),i.colorMask(!0,!0,!0,!0),i.clearColor(0,0,0,0),i.depthMask(!0),i.depthFunc(i.LESS),o.setReversed(!1),i.clearDepth(1),i.stencilMask(4294967295),i.stencilFunc(i.ALWAYS,0,4294967295),i.stencilOp(i.KEEP,i.KEEP,i.KEEP),i.clearStencil(0),i.cullFace(i.BACK),i.frontFace(i.CCW),i.polygonOffset(0,0),i.activeTexture(i.TEXTURE0),i.bindFramebuffer(i.FRAMEBUFFER,null),i.bindFramebuffer(i.DRAW_FRAMEBUFFER,null),i.bindFramebuffer(i.READ_FRAMEBUFFER,null),i.useProgram(null),i.lineWidth(1),i.scissor(0,0,i.canvas.width,i.canvas.height),i.viewport(0,0,i.canvas.width,i.canvas.height),i.pixelStorei(i.PACK_ALIGNMENT,4),i.pixelStorei(i.UNPACK_ALIGNMENT,4),i.pixelStorei(i.UNPACK_FLIP_Y_WEBGL,!1),i.pixelStorei(i.UNPACK_PREMULTIPLY_ALPHA_WEBGL,!1),i.pixelStorei(i.UNPACK_COLORSPACE_CONVERSION_WEBGL,i.BROWSER_DEFAULT_WEBGL),i.pixelStorei(i.PACK_ROW_LENGTH,0),i.pixelStorei(i.PACK_SKIP_PIXELS,0),i.pixelStorei(i.PACK_SKIP_ROWS,0),i.pixelStorei(i.UNPACK_ROW_LENGTH,0),i.pixelStorei(i.UNPACK_IMAGE_HEIGHT,0),i.pixelStorei(i.UNPACK_SKIP_PIXELS,0),i.pixelStorei(i.UNPACK_SKIP_ROWS,0),i.pixelStorei(i.UNPACK_SKIP_IMAGES,0),h={},f={},Q=null,st={},u={},l={},d=new WeakMap,g=[],M=null,m=!1,p=null,y=null,A=null,w=null,P=null,T=null,_=null,E=new Yt(0,0,0),V=0,D=!1,L=null,H=null,G=null,N=null,z=null,tt.set(0,0,i.canvas.width,i.canvas.height),mt.set(0,0,i.canvas.width,i.canvas.height),r.reset(),o.reset(),a.reset()}return{buffers:{color:r,depth:o,stencil:a},enable:St,disable:Wt,bindFramebuffer:oe,drawBuffers:Vt,useProgram:de,setBlending:$e,setMaterial:Be,setFlipSided:an,setCullFace:Le,setLineWidth:Sn,setPolygonOffset:be,setScissorTest:gn,activeTexture:je,bindTexture:ln,unbindTexture:F,compressedTexImage2D:Ct,compressedTexImage3D:Zt,texImage2D:v,texImage3D:W,pixelStorei:ot,getParameter:ht,updateUBOMapping:et,uniformBlockBinding:it,texStorage2D:$t,texStorage3D:R,texSubImage2D:ae,texSubImage3D:Mt,compressedTexSubImage2D:Ue,compressedTexSubImage3D:zt,scissor:xt,viewport:vt,reset:pt}}function VE(i,t,e,n,s,r,o){let a=t.has("WEBGL_multisampled_render_to_texture")?t.get("WEBGL_multisampled_render_to_texture"):null,l=typeof navigator>"u"?!1:/OculusBrowser/g.test(navigator.userAgent),c=new Jt,h=new WeakMap,f=new Set,u,d=new WeakMap,g=new Set,M=new FinalizationRegistry(R=>g.delete(R)),m=!1;try{m=typeof OffscreenCanvas<"u"&&new OffscreenCanvas(1,1).getContext("2d")!==null}catch{}function p(R,v){return m?new OffscreenCanvas(R,v):ta("canvas")}function y(R,v,W){let ht=1,ot=$t(R);if((ot.width>W||ot.height>W)&&(ht=W/Math.max(ot.width,ot.height)),ht<1)if(typeof HTMLImageElement<"u"&&R instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&R instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&R instanceof ImageBitmap||typeof VideoFrame<"u"&&R instanceof VideoFrame){let xt=Math.floor(ht*ot.width),vt=Math.floor(ht*ot.height);u===void 0&&(u=p(xt,vt));let et=v?p(xt,vt):u;return et.width=xt,et.height=vt,et.getContext("2d").drawImage(R,0,0,xt,vt),jt("WebGLRenderer: Texture has been resized from ("+ot.width+"x"+ot.height+") to ("+xt+"x"+vt+")."),et}else return"data"in R&&jt("WebGLRenderer: Image in DataTexture is too big ("+ot.width+"x"+ot.height+")."),R;return R}function A(R){return R.generateMipmaps}function w(R){i.generateMipmap(R)}function P(R){return R.isWebGLCubeRenderTarget?i.TEXTURE_CUBE_MAP:R.isWebGL3DRenderTarget?i.TEXTURE_3D:R.isWebGLArrayRenderTarget||R.isCompressedArrayTexture?i.TEXTURE_2D_ARRAY:i.TEXTURE_2D}function T(R,v,W,ht,ot,xt=!1){if(R!==null){if(i[R]!==void 0)return i[R];jt("WebGLRenderer: Attempt to use non-existing WebGL internal format '"+R+"'")}let vt;ht&&(vt=t.get("EXT_texture_norm16"),vt||jt("WebGLRenderer: Unable to use normalized textures without EXT_texture_norm16 extension"));let et=v;if(v===i.RED&&(W===i.FLOAT&&(et=i.R32F),W===i.HALF_FLOAT&&(et=i.R16F),W===i.UNSIGNED_BYTE&&(et=i.R8),W===i.UNSIGNED_SHORT&&vt&&(et=vt.R16_EXT),W===i.SHORT&&vt&&(et=vt.R16_SNORM_EXT)),v===i.RED_INTEGER&&(W===i.UNSIGNED_BYTE&&(et=i.R8UI),W===i.UNSIGNED_SHORT&&(et=i.R16UI),W===i.UNSIGNED_INT&&(et=i.R32UI),W===i.BYTE&&(et=i.R8I),W===i.SHORT&&(et=i.R16I),W===i.INT&&(et=i.R32I)),v===i.RG&&(W===i.FLOAT&&(et=i.RG32F),W===i.HALF_FLOAT&&(et=i.RG16F),W===i.UNSIGNED_BYTE&&(et=i.RG8),W===i.UNSIGNED_SHORT&&vt&&(et=vt.RG16_EXT),W===i.SHORT&&vt&&(et=vt.RG16_SNORM_EXT)),v===i.RG_INTEGER&&(W===i.UNSIGNED_BYTE&&(et=i.RG8UI),W===i.UNSIGNED_SHORT&&(et=i.RG16UI),W===i.UNSIGNED_INT&&(et=i.RG32UI),W===i.BYTE&&(et=i.RG8I),W===i.SHORT&&(et=i.RG16I),W===i.INT&&(et=i.RG32I)),v===i.RGB_INTEGER&&(W===i.UNSIGNED_BYTE&&(et=i.RGB8UI),W===i.UNSIGNED_SHORT&&(et=i.RGB16UI),W===i.UNSIGNED_INT&&(et=i.RGB32UI),W===i.BYTE&&(et=i.RGB8I),W===i.SHORT&&(et=i.RGB16I),W===i.INT&&(et=i.RGB32I)),v===i.RGBA_INTEGER&&(W===i.UNSIGNED_BYTE&&(et=i.RGBA8UI),W===i.UNSIGNED_SHORT&&(et=i.RGBA16UI),W===i.UNSIGNED_INT&&(et=i.RGBA32UI),W===i.BYTE&&(et=i.RGBA8I),W===i.SHORT&&(et=i.RGBA16I),W===i.INT&&(et=i.RGBA32I)),v===i.RGB&&(W===i.UNSIGNED_SHORT&&vt&&(et=vt.RGB16_EXT),W===i.SHORT&&vt&&(et=vt.RGB16_SNORM_EXT),W===i.UNSIGNED_INT_5_9_9_9_REV&&(et=i.RGB9_E5),W===i.UNSIGNED_INT_10F_11F_11F_REV&&(et=i.R11F_G11F_B10F)),v===i.RGBA){let it=xt?jo:ge.getTransfer(ot);W===i.FLOAT&&(et=i.RGBA32F),W===i.HALF_FLOAT&&(et=i.RGBA16F),W===i.UNSIGNED_BYTE&&(et=it===Re?i.SRGB8_ALPHA8:i.RGBA8),W===i.UNSIGNED_SHORT&&vt&&(et=vt.RGBA16_EXT),W===i.SHORT&&vt&&(et=vt.RGBA16_SNORM_EXT),W===i.UNSIGNED_SHORT_4_4_4_4&&(et=i.RGBA4),W===i.UNSIGNED_SHORT_5_5_5_1&&(et=i.RGB5_A1)}return(et===i.R16F||et===i.R32F||et===i.RG16F||et===i.RG32F||et===i.RGBA16F||et===i.RGBA32F)&&t.get("EXT_color_buffer_float"),et}function _(R,v){let W;return R?v===null||v===Li||v===Sr?W=i.DEPTH24_STENCIL8:v===Ni?W=i.DEPTH32F_STENCIL8:v===So&&(W=i.DEPTH24_STENCIL8,jt("DepthTexture: 16 bit depth attachment is not supported with stencil. Using 24-bit attachment.")):v===null||v===Li||v===Sr?W=i.DEPTH_COMPONENT24:v===Ni?W=i.DEPTH_COMPONENT32F:v===So&&(W=i.DEPTH_COMPONENT16),W}function E(R,v){return A(R)===!0||R.isFramebufferTexture&&R.minFilter!==on&&R.minFilter!==Zn?Math.log2(Math.max(v.width,v.height))+1:R.mipmaps.length>0?R.mipmaps.length:R.isCompressedTexture&&Array.isArray(R.image)?v.mipmaps.length:1}function V(R){let v=new WeakRef(R);n.get(R).__ref=v,g.add(v),M.register(R,v,v)}function D(R){let v=n.get(R).__ref;v!==void 0&&(g.delete(v),M.unregister(v))}function L(R){G(R.target)}function H(R){N(R.target)}function G(R){R.removeEventListener("dispose",L),D(R),J(R),R.isVideoTexture&&h.delete(R),R.isHTMLTexture&&f.delete(R)}function N(R){R.removeEventListener("dispose",H),D(R),ct(R)}function z(){for(let R of g){let v=R.deref();v!==void 0&&(v.isRenderTarget===!0?N(v):G(v))}g.clear(),f.clear()}function J(R){let v=n.get(R);if(v.__webglInit===void 0)return;let W=R.source,ht=d.get(W);if(ht){let ot=ht[v.__cacheKey];ot.usedTimes--,ot.usedTimes===0&&k(R),Object.keys(ht).length===0&&d.delete(W)}n.remove(R)}function k(R){let v=n.get(R);i.deleteTexture(v.__webglTexture);let W=R.source,ht=d.get(W);delete ht[v.__cacheKey],o.memory.textures--}function ct(R){let v=n.get(R);v.__depthDisposeCallback&&v.__depthDisposeCallback();let W=R.depthTexture;if(W&&W.renderTarget===R&&G(W),R.isWebGLCubeRenderTarget)for(let ot=0;ot<6;ot++){if(Array.isArray(v.__webglFramebuffer[ot]))for(let xt=0;xt<v.__webglFramebuffer[ot].length;xt++)i.deleteFramebuffer(v.__webglFramebuffer[ot][xt]);else i.deleteFramebuffer(v.__webglFramebuffer[ot]);v.__webglDepthbuffer&&i.deleteRenderbuffer(v.__webglDepthbuffer[ot])}else{if(Array.isArray(v.__webglFramebuffer))for(let ot=0;ot<v.__webglFramebuffer.length;ot++)i.deleteFramebuffer(v.__webglFramebuffer[ot]);else i.deleteFramebuffer(v.__webglFramebuffer);if(v.__webglDepthbuffer&&i.deleteRenderbuffer(v.__webglDepthbuffer),v.__webglMultisampledFramebuffer&&i.deleteFramebuffer(v.__webglMultisampledFramebuffer),v.__webglColorRenderbuffer)for(let ot=0;ot<v.__webglColorRenderbuffer.length;ot++)v.__webglColorRenderbuffer[ot]&&i.deleteRenderbuffer(v.__webglColorRenderbuffer[ot]);v.__webglDepthRenderbuffer&&i.deleteRenderbuffer(v.__webglDepthRenderbuffer)}let ht=R.textures;for(let ot=0,xt=ht.length;ot<xt;ot++){let vt=n.get(ht[ot]);vt.__webglTexture&&(i.deleteTexture(vt.__webglTexture),o.memory.textures--),n.remove(ht[ot])}n.remove(R)}let K=0;function Q(){K=0}function st(){return K}function ft(R){K=R}function ut(){let R=K;return R>=s.maxTextures&&jt("WebGLTextures: Trying to use "+(R+1)+" texture units while this GPU supports only "+s.maxTextures),K+=1,R}function tt(R){let v=[];return v.push(R.wrapS),v.push(R.wrapT),v.push(R.wrapR||0),v.push(R.magFilter),v.push(R.minFilter),v.push(R.anisotropy),v.push(R.internalFormat),v.push(R.format),v.push(R.type),v.push(R.generateMipmaps),v.push(R.mipmapsAutoUpdate),v.push(R.premultiplyAlpha),v.push(R.flipY),v.push(R.unpackAlignment),v.push(R.colorSpace),v.join()}function mt(R,v){let W=n.get(R);if(R.isVideoTexture&&Ue(R),R.isRenderTargetTexture===!1&&R.isExternalTexture!==!0&&R.version>0&&W.__version!==R.version){let ht=R.image;if(ht===null)jt("WebGLRenderer: Texture marked for update but no image data found.");else if(ht.complete===!1)jt("WebGLRenderer: Texture marked for update but image is incomplete");else{Be(W,R,v);return}}else R.isExternalTexture&&(W.__webglTexture=R.sourceTexture?R.sourceTexture:null);e.bindTexture(i.TEXTURE_2D,W.__webglTexture,i.TEXTURE0+v)}function _t(R,v){let W=n.get(R);if(R.isRenderTargetTexture===!1&&R.version>0&&W.__version!==R.version){Be(W,R,v);return}else R.isExternalTexture&&(W.__webglTexture=R.sourceTexture?R.sourceTexture:null);e.bindTexture(i.TEXTURE_2D_ARRAY,W.__webglTexture,i.TEXTURE0+v)}function At(R,v){let W=n.get(R);if(R.isRenderTargetTexture===!1&&R.version>0&&W.__version!==R.version){Be(W,R,v);return}e.bindTexture(i.TEXTURE_3D,W.__webglTexture,i.TEXTURE0+v)}function St(R,v){let W=n.get(R);if(R.version>0&&W.__version!==R.version){an(W,R,v);return}e.bindTexture(i.TEXTURE_CUBE_MAP,W.__webglTexture,i.TEXTURE0+v)}let Wt={[sc]:i.REPEAT,[Yi]:i.CLAMP_TO_EDGE,[rc]:i.MIRRORED_REPEAT},oe={[on]:i.NEAREST,[a0]:i.NEAREST_MIPMAP_NEAREST,[va]:i.NEAREST_MIPMAP_LINEAR,[Zn]:i.LINEAR,[Dc]:i.LINEAR_MIPMAP_NEAREST,[xs]:i.LINEAR_MIPMAP_LINEAR},Vt={[u0]:i.NEVER,[nd]:i.ALWAYS,[f0]:i.LESS,[td]:i.LEQUAL,[d0]:i.EQUAL,[ed]:i.GEQUAL,[p0]:i.GREATER,[m0]:i.NOTEQUAL};function de(R,v){if(v.type===Ni&&t.has("OES_texture_float_linear")===!1&&(v.magFilter===Zn||v.magFilter===Dc||v.magFilter===va||v.magFilter===xs||v.minFilter===Zn||v.minFilter===Dc||v.minFilter===va||v.minFilter===xs)&&jt("WebGLRenderer: Unable to use linear filtering with floating point textures. OES_texture_float_linear not supported on this device."),i.texParameteri(R,i.TEXTURE_WRAP_S,Wt[v.wrapS]),i.texParameteri(R,i.TEXTURE_WRAP_T,Wt[v.wrapT]),(R===i.TEXTURE_3D||R===i.TEXTURE_2D_ARRAY)&&i.texParameteri(R,i.TEXTURE_WRAP_R,Wt[v.wrapR]),i.texParameteri(R,i.TEXTURE_MAG_FILTER,oe[v.magFilter]),i.texParameteri(R,i.TEXTURE_MIN_FILTER,oe[v.minFilter]),v.compareFunction&&(i.texParameteri(R,i.TEXTURE_COMPARE_MODE,i.COMPARE_REF_TO_TEXTURE),i.texParameteri(R,i.TEXTURE_COMPARE_FUNC,Vt[v.compareFunction])),t.has("EXT_texture_filter_anisotropic")===!0){if(v.magFilter===on||v.minFilter!==va&&v.minFilter!==xs||v.type===Ni&&t.has("OES_texture_float_linear")===!1)return;if(v.anisotropy>1||n.get(v).__currentAnisotropy){let W=t.get("EXT_texture_filter_anisotropic");i.texParameterf(R,W.TEXTURE_MAX_ANISOTROPY_EXT,Math.min(v.anisotropy,s.getMaxAnisotropy())),n.get(v).__currentAnisotropy=v.anisotropy}}}function he(R,v){let W=!1;R.__webglInit===void 0&&(R.__webglInit=!0,v.addEventListener("dispose",L),V(v));let ht=v.source,ot=d.get(ht);ot===void 0&&(ot={},d.set(ht,ot));let xt=tt(v);if(xt!==R.__cacheKey){ot[xt]===void 0&&(ot[xt]={texture:i.createTexture(),usedTimes:0},o.memory.textures++,W=!0),ot[xt].usedTimes++;let vt=ot[R.__cacheKey];vt!==void 0&&(ot[R.__cacheKey].usedTimes--,vt.usedTimes===0&&k(v)),R.__cacheKey=xt,R.__webglTexture=ot[xt].texture}return W}function se(R,v,W){return Math.floor(Math.floor(R/W)/v)}function $e(R,v,W,ht){let xt=R.updateRanges;if(xt.length===0)e.texSubImage2D(i.TEXTURE_2D,0,0,0,v.width,v.height,W,ht,v.data);else{xt.sort((U,rt)=>U.start-rt.start);let vt=0;for(let U=1;U<xt.length;U++){let rt=xt[vt],nt=xt[U],wt=rt.start+rt.count,gt=se(nt.start,v.width,4),bt=se(rt.start,v.width,4);nt.start<=wt+1&&gt===bt&&se(nt.start+nt.count-1,v.width,4)===gt?rt.count=Math.max(rt.count,nt.start+nt.count-rt.start):(++vt,xt[vt]=nt)}xt.length=vt+1;let et=e.getParameter(i.UNPACK_ROW_LENGTH),it=e.getParameter(i.UNPACK_SKIP_PIXELS),pt=e.getParameter(i.UNPACK_SKIP_ROWS);e.pixelStorei(i.UNPACK_ROW_LENGTH,v.width);for(let U=0,rt=xt.length;U<rt;U++){let nt=xt[U],wt=Math.floor(nt.start/4),gt=Math.ceil(nt.count/4),bt=wt%v.width,Ht=Math.floor(wt/v.width),Qt=gt,lt=1;e.pixelStorei(i.UNPACK_SKIP_PIXELS,bt),e.pixelStorei(i.UNPACK_SKIP_ROWS,Ht),e.texSubImage2D(i.TEXTURE_2D,0,bt,Ht,Qt,lt,W,ht,v.data)}R.clearUpdateRanges(),e.pixelStorei(i.UNPACK_ROW_LENGTH,et),e.pixelStorei(i.UNPACK_SKIP_PIXELS,it),e.pixelStorei(i.UNPACK_SKIP_ROWS,pt)}}function Be(R,v,W){let ht=i.TEXTURE_2D;(v.isDataArrayTexture||v.isCompressedArrayTexture)&&(ht=i.TEXTURE_2D_ARRAY),v.isData3DTexture&&(ht=i.TEXTURE_3D);let ot=he(R,v),xt=v.source;e.bindTexture(ht,R.__webglTexture,i.TEXTURE0+W);let vt=n.get(xt);if(xt.version!==vt.__version||ot===!0){if(e.activeTexture(i.TEXTURE0+W),(typeof ImageBitmap<"u"&&v.image instanceof ImageBitmap)===!1){let lt=ge.getPrimaries(ge.workingColorSpace),Ot=v.colorSpace===vs?null:ge.getPrimaries(v.colorSpace),te=v.colorSpace===vs||lt===Ot?i.NONE:i.BROWSER_DEFAULT_WEBGL;e.pixelStorei(i.UNPACK_FLIP_Y_WEBGL,v.flipY),e.pixelStorei(i.UNPACK_PREMULTIPLY_ALPHA_WEBGL,v.premultiplyAlpha),e.pixelStorei(i.UNPACK_COLORSPACE_CONVERSION_WEBGL,te)}e.pixelStorei(i.UNPACK_ALIGNMENT,v.unpackAlignment);let it=y(v.image,!1,s.maxTextureSize);it=zt(v,it);let pt=r.convert(v.format,v.colorSpace),U=r.convert(v.type),rt=T(v.internalFormat,pt,U,v.normalized,v.colorSpace,v.isVideoTexture);de(ht,v);let nt,wt=v.mipmaps,gt=v.isVideoTexture!==!0,bt=vt.__version===void 0||ot===!0,Ht=xt.dataReady,Qt=E(v,it);if(v.isDepthTexture)rt=_(v.format===_s,v.type),bt&&(gt?e.texStorage2D(i.TEXTURE_2D,1,rt,it.width,it.height):e.texImage2D(i.TEXTURE_2D,0,rt,it.width,it.height,0,pt,U,null));else if(v.isDataTexture)if(wt.length>0){gt&&bt&&e.texStorage2D(i.TEXTURE_2D,Qt,rt,wt[0].width,wt[0].height);for(let lt=0,Ot=wt.length;lt<Ot;lt++)nt=wt[lt],gt?Ht&&e.texSubImage2D(i.TEXTURE_2D,lt,0,0,nt.width,nt.height,pt,U,nt.data):e.texImage2D(i.TEXTURE_2D,lt,rt,nt.width,nt.height,0,pt,U,nt.data);v.generateMipmaps=!1}else gt?(bt&&e.texStorage2D(i.TEXTURE_2D,Qt,rt,it.width,it.height),Ht&&$e(v,it,pt,U)):e.texImage2D(i.TEXTURE_2D,0,rt,it.width,it.height,0,pt,U,it.data);else if(v.isCompressedTexture)if(v.isCompressedArrayTexture){gt&&bt&&e.texStorage3D(i.TEXTURE_2D_ARRAY,Qt,rt,wt[0].width,wt[0].height,it.depth);for(let lt=0,Ot=wt.length;lt<Ot;lt++)if(nt=wt[lt],v.format!==Ui)if(pt!==null)if(gt){if(Ht)if(v.layerUpdates.size>0){let te=ld(nt.width,nt.height,v.format,v.type);for(let Rt of v.layerUpdates){let ce=nt.data.subarray(Rt*te/nt.data.BYTES_PER_ELEMENT,(Rt+1)*te/nt.data.BYTES_PER_ELEMENT);e.compressedTexSubImage3D(i.TEXTURE_2D_ARRAY,lt,0,0,Rt,nt.width,nt.height,1,pt,ce)}}else e.compressedTexSubImage3D(i.TEXTURE_2D_ARRAY,lt,0,0,0,nt.width,nt.height,it.depth,pt,nt.data)}else e.compressedTexImage3D(i.TEXTURE_2D_ARRAY,lt,rt,nt.width,nt.height,it.depth,0,nt.data,0,0);else jt("WebGLRenderer: Attempt to load unsupported compressed texture format in .uploadTexture()");else gt?Ht&&e.texSubImage3D(i.TEXTURE_2D_ARRAY,lt,0,0,0,nt.width,nt.height,it.depth,pt,U,nt.data):e.texImage3D(i.TEXTURE_2D_ARRAY,lt,rt,nt.width,nt.height,it.depth,0,pt,U,nt.data);v.layerUpdates.size>0&&v.clearLayerUpdates()}else{gt&&bt&&e.texStorage2D(i.TEXTURE_2D,Qt,rt,wt[0].width,wt[0].height);for(let lt=0,Ot=wt.length;lt<Ot;lt++)nt=wt[lt],v.format!==Ui?pt!==null?gt?Ht&&e.compressedTexSubImage2D(i.TEXTURE_2D,lt,0,0,nt.width,nt.height,pt,nt.data):e.compressedTexImage2D(i.TEXTURE_2D,lt,rt,nt.width,nt.height,0,nt.data):jt("WebGLRenderer: Attempt to load unsupported compressed texture format in .uploadTexture()"):gt?Ht&&e.texSubImage2D(i.TEXTURE_2D,lt,0,0,nt.width,nt.height,pt,U,nt.data):e.texImage2D(i.TEXTURE_2D,lt,rt,nt.width,nt.height,0,pt,U,nt.data)}else if(v.isDataArrayTexture)if(gt){if(bt&&e.texStorage3D(i.TEXTURE_2D_ARRAY,Qt,rt,it.width,it.height,it.depth),Ht)if(v.layerUpdates.size>0){let lt=ld(it.width,it.height,v.format,v.type);for(let Ot of v.layerUpdates){let te=it.data.subarray(Ot*lt/it.data.BYTES_PER_ELEMENT,(Ot+1)*lt/it.data.BYTES_PER_ELEMENT);e.texSubImage3D(i.TEXTURE_2D_ARRAY,0,0,0,Ot,it.width,it.height,1,pt,U,te)}v.clearLayerUpdates()}else e.texSubImage3D(i.TEXTURE_2D_ARRAY,0,0,0,0,it.width,it.height,it.depth,pt,U,it.data)}else e.texImage3D(i.TEXTURE_2D_ARRAY,0,rt,it.width,it.height,it.depth,0,pt,U,it.data);else if(v.isData3DTexture)gt?(bt&&e.texStorage3D(i.TEXTURE_3D,Qt,rt,it.width,it.height,it.depth),Ht&&e.texSubImage3D(i.TEXTURE_3D,0,0,0,0,it.width,it.height,it.depth,pt,U,it.data)):e.texImage3D(i.TEXTURE_3D,0,rt,it.width,it.height,it.depth,0,pt,U,it.data);else if(v.isFramebufferTexture){if(bt)if(gt)e.texStorage2D(i.TEXTURE_2D,Qt,rt,it.width,it.height);else{let lt=it.width,Ot=it.height;for(let te=0;te<Qt;te++)e.texImage2D(i.TEXTURE_2D,te,rt,lt,Ot,0,pt,U,null),lt>>=1,Ot>>=1}}else if(v.isHTMLTexture){if("texElementImage2D"in i){let lt=i.canvas;if(lt.hasAttribute("layoutsubtree")||lt.setAttribute("layoutsubtree","true"),it.parentNode!==lt){lt.appendChild(it),f.add(v),lt.onpaint=Ot=>{let te=Ot.changedElements;for(let Rt of f)te.includes(Rt.image)&&(Rt.needsUpdate=!0)},lt.requestPaint();return}if(i.texElementImage2D.length===3)i.texElementImage2D(i.TEXTURE_2D,i.RGBA8,it);else{let te=i.RGBA,Rt=i.RGBA,ce=i.UNSIGNED_BYTE;i.texElementImage2D(i.TEXTURE_2D,0,te,Rt,ce,it)}i.texParameteri(i.TEXTURE_2D,i.TEXTURE_MIN_FILTER,i.LINEAR),i.texParameteri(i.TEXTURE_2D,i.TEXTURE_WRAP_S,i.CLAMP_TO_EDGE),i.texParameteri(i.TEXTURE_2D,i.TEXTURE_WRAP_T,i.CLAMP_TO_EDGE)}}else if(wt.length>0){if(gt&&bt){let lt=$t(wt[0]);e.texStorage2D(i.TEXTURE_2D,Qt,rt,lt.width,lt.height)}for(let lt=0,Ot=wt.length;lt<Ot;lt++)nt=wt[lt],gt?Ht&&e.texSubImage2D(i.TEXTURE_2D,lt,0,0,pt,U,nt):e.texImage2D(i.TEXTURE_2D,lt,rt,pt,U,nt);v.generateMipmaps=!1}else if(gt){if(bt){let lt=$t(it);e.texStorage2D(i.TEXTURE_2D,Qt,rt,lt.width,lt.height)}Ht&&e.texSubImage2D(i.TEXTURE_2D,0,0,0,pt,U,it)}else e.texImage2D(i.TEXTURE_2D,0,rt,pt,U,it);A(v)&&v.mipmapsAutoUpdate===!0&&w(ht),vt.__version=xt.version,v.onUpdate&&v.onUpdate(v)}R.__version=v.version}function an(R,v,W){if(v.image.length!==6)return;let ht=he(R,v),ot=v.source;e.bindTexture(i.TEXTURE_CUBE_MAP,R.__webglTexture,i.TEXTURE0+W);let xt=n.get(ot);if(ot.version!==xt.__version||ht===!0){e.activeTexture(i.TEXTURE0+W);let vt=ge.getPrimaries(ge.workingColorSpace),et=v.colorSpace===vs?null:ge.getPrimaries(v.colorSpace),it=v.colorSpace===vs||vt===et?i.NONE:i.BROWSER_DEFAULT_WEBGL;e.pixelStorei(i.UNPACK_FLIP_Y_WEBGL,v.flipY),e.pixelStorei(i.UNPACK_PREMULTIPLY_ALPHA_WEBGL,v.premultiplyAlpha),e.pixelStorei(i.UNPACK_ALIGNMENT,v.unpackAlignment),e.pixelStorei(i.UNPACK_COLORSPACE_CONVERSION_WEBGL,it);let pt=v.isCompressedTexture||v.image[0].isCompressedTexture,U=v.image[0]&&v.image[0].isDataTexture,rt=[];for(let Rt=0;Rt<6;Rt++)!pt&&!U?rt[Rt]=y(v.image[Rt],!0,s.maxCubemapSize):rt[Rt]=U?v.image[Rt].image:v.image[Rt],rt[Rt]=zt(v,rt[Rt]);let nt=rt[0],wt=r.convert(v.format,v.colorSpace),gt=r.convert(v.type),bt=T(v.internalFormat,wt,gt,v.normalized,v.colorSpace),Ht=v.isVideoTexture!==!0,Qt=xt.__version===void 0||ht===!0,lt=ot.dataReady,Ot=E(v,nt);de(i.TEXTURE_CUBE_MAP,v);let te;if(v.isDepthTexture){if(bt=_(v.format===_s,v.type),Qt)if(Ht)e.texStorage2D(i.TEXTURE_CUBE_MAP,1,bt,nt.width,nt.height);else for(let Rt=0;Rt<6;Rt++)e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,0,bt,nt.width,nt.height,0,wt,gt,null)}else if(pt){Ht&&Qt&&e.texStorage2D(i.TEXTURE_CUBE_MAP,Ot,bt,nt.width,nt.height);for(let Rt=0;Rt<6;Rt++){te=rt[Rt].mipmaps;for(let ce=0;ce<te.length;ce++){let ze=te[ce];v.format!==Ui?wt!==null?Ht?lt&&e.compressedTexSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,ce,0,0,ze.width,ze.height,wt,ze.data):e.compressedTexImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,ce,bt,ze.width,ze.height,0,ze.data):jt("WebGLRenderer: Attempt to load unsupported compressed texture format in .setTextureCube()"):Ht?lt&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,ce,0,0,ze.width,ze.height,wt,gt,ze.data):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,ce,bt,ze.width,ze.height,0,wt,gt,ze.data)}}}else{if(te=v.mipmaps,Ht&&Qt){te.length>0&&Ot++;let Rt=$t(rt[0]);e.texStorage2D(i.TEXTURE_CUBE_MAP,Ot,bt,Rt.width,Rt.height)}for(let Rt=0;Rt<6;Rt++)if(U){Ht?lt&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,0,0,0,rt[Rt].width,rt[Rt].height,wt,gt,rt[Rt].data):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,0,bt,rt[Rt].width,rt[Rt].height,0,wt,gt,rt[Rt].data);for(let ce=0;ce<te.length;ce++){let kn=te[ce].image[Rt].image;Ht?lt&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,ce+1,0,0,kn.width,kn.height,wt,gt,kn.data):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,ce+1,bt,kn.width,kn.height,0,wt,gt,kn.data)}}else{Ht?lt&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,0,0,0,wt,gt,rt[Rt]):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,0,bt,wt,gt,rt[Rt]);for(let ce=0;ce<te.length;ce++){let ze=te[ce];Ht?lt&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,ce+1,0,0,wt,gt,ze.image[Rt]):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+Rt,ce+1,bt,wt,gt,ze.image[Rt])}}}A(v)&&v.mipmapsAutoUpdate===!0&&w(i.TEXTURE_CUBE_MAP),xt.__version=ot.version,v.onUpdate&&v.onUpdate(v)}R.__version=v.version}function Le(R,v,W,ht,ot,xt){let vt=r.convert(W.format,W.colorSpace),et=r.convert(W.type),it=T(W.internalFormat,vt,et,W.normalized,W.colorSpace),pt=n.get(v),U=n.get(W);if(U.__renderTarget=v,!pt.__hasExternalTextures){let rt=Math.max(1,v.width>>xt),nt=Math.max(1,v.height>>xt);ot===i.TEXTURE_3D||ot===i.TEXTURE_2D_ARRAY?e.texImage3D(ot,xt,it,rt,nt,v.depth,0,vt,et,null):e.texImage2D(ot,xt,it,rt,nt,0,vt,et,null)}e.bindFramebuffer(i.FRAMEBUFFER,R),Mt(v)?a.framebufferTexture2DMultisampleEXT(i.FRAMEBUFFER,ht,ot,U.__webglTexture,0,ae(v)):(ot===i.TEXTURE_2D||ot>=i.TEXTURE_CUBE_MAP_POSITIVE_X&&ot<=i.TEXTURE_CUBE_MAP_NEGATIVE_Z)&&i.framebufferTexture2D(i.FRAMEBUFFER,ht,ot,U.__webglTexture,xt),e.bindFramebuffer(i.FRAMEBUFFER,null)}function Sn(R,v,W){if(i.bindRenderbuffer(i.RENDERBUFFER,R),v.depthBuffer){let ht=v.depthTexture,ot=ht&&ht.isDepthTexture?ht.type:null,xt=_(v.stencilBuffer,ot),vt=v.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT;Mt(v)?a.renderbufferStorageMultisampleEXT(i.RENDERBUFFER,ae(v),xt,v.width,v.height):W?i.renderbufferStorageMultisample(i.RENDERBUFFER,ae(v),xt,v.width,v.height):i.renderbufferStorage(i.RENDERBUFFER,xt,v.width,v.height),i.framebufferRenderbuffer(i.FRAMEBUFFER,vt,i.RENDERBUFFER,R)}else{let ht=v.textures;for(let ot=0;ot<ht.length;ot++){let xt=ht[ot],vt=r.convert(xt.format,xt.colorSpace),et=r.convert(xt.type),it=T(xt.internalFormat,vt,et,xt.normalized,xt.colorSpace);Mt(v)?a.renderbufferStorageMultisampleEXT(i.RENDERBUFFER,ae(v),it,v.width,v.height):W?i.renderbufferStorageMultisample(i.RENDERBUFFER,ae(v),it,v.width,v.height):i.renderbufferStorage(i.RENDERBUFFER,it,v.width,v.height)}}i.bindRenderbuffer(i.RENDERBUFFER,null)}function be(R,v,W){let ht=v.isWebGLCubeRenderTarget===!0;if(e.bindFramebuffer(i.FRAMEBUFFER,R),!(v.depthTexture&&v.depthTexture.isDepthTexture))throw new Error("THREE.WebGLTextures: renderTarget.depthTexture must be an instance of THREE.DepthTexture.");let ot=n.get(v.depthTexture);ot.__renderTarget=v;let xt=ht?v.depthTexture.image[0]:v.depthTexture.image;(!ot.__webglTexture||xt.width!==v.width||xt.height!==v.height)&&(xt.width=v.width,xt.height=v.height,v.depthTexture.needsUpdate=!0),ht?St(v.depthTexture,0):mt(v.depthTexture,0);let vt=ot.__webglTexture,et=ae(v),it=ht?i.TEXTURE_CUBE_MAP_POSITIVE_X+W:i.TEXTURE_2D,pt=v.depthTexture.format===_s?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT;if(v.depthTexture.format===ms)Mt(v)?a.framebufferTexture2DMultisampleEXT(i.FRAMEBUFFER,pt,it,vt,0,et):i.framebufferTexture2D(i.FRAMEBUFFER,pt,it,vt,0);else if(v.depthTexture.format===_s)Mt(v)?a.framebufferTexture2DMultisampleEXT(i.FRAMEBUFFER,pt,it,vt,0,et):i.framebufferTexture2D(i.FRAMEBUFFER,pt,it,vt,0);else throw new Error("THREE.WebGLTextures: Unknown depthTexture format.")}function gn(R){let v=n.get(R),W=R.isWebGLCubeRenderTarget===!0;if(v.__boundDepthTexture!==R.depthTexture){let ht=R.depthTexture;if(v.__depthDisposeCallback&&v.__depthDisposeCallback(),ht){let ot=()=>{delete v.__boundDepthTexture,delete v.__depthDisposeCallback,ht.removeEventListener("dispose",ot)};ht.addEventListener("dispose",ot),v.__depthDisposeCallback=ot}v.__boundDepthTexture=ht}if(R.depthTexture&&!v.__autoAllocateDepthBuffer)if(W)for(let ht=0;ht<6;ht++)be(v.__webglFramebuffer[ht],R,ht);else R.texture.mipmaps.length>0?be(v.__webglFramebuffer[0],R,0):be(v.__webglFramebuffer,R,0);else if(W){v.__webglDepthbuffer=[];for(let ht=0;ht<6;ht++)if(e.bindFramebuffer(i.FRAMEBUFFER,v.__webglFramebuffer[ht]),v.__webglDepthbuffer[ht]===void 0)v.__webglDepthbuffer[ht]=i.createRenderbuffer(),Sn(v.__webglDepthbuffer[ht],R,!1);else{let ot=R.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT,xt=v.__webglDepthbuffer[ht];i.bindRenderbuffer(i.RENDERBUFFER,xt),i.framebufferRenderbuffer(i.FRAMEBUFFER,ot,i.RENDERBUFFER,xt)}}else if(R.texture.mipmaps.length>0?e.bindFramebuffer(i.FRAMEBUFFER,v.__webglFramebuffer[0]):e.bindFramebuffer(i.FRAMEBUFFER,v.__webglFramebuffer),v.__webglDepthbuffer===void 0)v.__webglDepthbuffer=i.createRenderbuffer(),Sn(v.__webglDepthbuffer,R,!1);else{let ot=R.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT,xt=v.__webglDepthbuffer;i.bindRenderbuffer(i.RENDERBUFFER,xt),i.framebufferRenderbuffer(i.FRAMEBUFFER,ot,i.RENDERBUFFER,xt)}e.bindFramebuffer(i.FRAMEBUFFER,null)}function je(R,v,W){let ht=n.get(R);v!==void 0&&Le(ht.__webglFramebuffer,R,R.texture,i.COLOR_ATTACHMENT0,i.TEXTURE_2D,0),W!==void 0&&gn(R)}function ln(R){let v=R.texture,W=n.get(R),ht=n.get(v);R.addEventListener("dispose",H),V(R);let ot=R.textures,xt=R.isWebGLCubeRenderTarget===!0,vt=ot.length>1;if(vt||(ht.__webglTexture===void 0&&(ht.__webglTexture=i.createTexture()),ht.__version=v.version,o.memory.textures++),xt){W.__webglFramebuffer=[];for(let et=0;et<6;et++)if(v.mipmaps.length>0){W.__webglFramebuffer[et]=[];for(let it=0;it<v.mipmaps.length;it++)W.__webglFramebuffer[et][it]=i.createFramebuffer()}else W.__webglFramebuffer[et]=i.createFramebuffer()}else{if(v.mipmaps.length>0){W.__webglFramebuffer=[];for(let et=0;et<v.mipmaps.length;et++)W.__webglFramebuffer[et]=i.createFramebuffer()}else W.__webglFramebuffer=i.createFramebuffer();if(vt)for(let et=0,it=ot.length;et<it;et++){let pt=n.get(ot[et]);pt.__webglTexture===void 0&&(pt.__webglTexture=i.createTexture(),o.memory.textures++)}if(R.samples>0&&Mt(R)===!1){W.__webglMultisampledFramebuffer=i.createFramebuffer(),W.__webglColorRenderbuffer=[],e.bindFramebuffer(i.FRAMEBUFFER,W.__webglMultisampledFramebuffer);for(let et=0;et<ot.length;et++){let it=ot[et];W.__webglColorRenderbuffer[et]=i.createRenderbuffer(),i.bindRenderbuffer(i.RENDERBUFFER,W.__webglColorRenderbuffer[et]);let pt=r.convert(it.format,it.colorSpace),U=r.convert(it.type),rt=T(it.internalFormat,pt,U,it.normalized,it.colorSpace,R.isXRRenderTarget===!0),nt=ae(R);i.renderbufferStorageMultisample(i.RENDERBUFFER,nt,rt,R.width,R.height),i.framebufferRenderbuffer(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0+et,i.RENDERBUFFER,W.__webglColorRenderbuffer[et])}i.bindRenderbuffer(i.RENDERBUFFER,null),R.depthBuffer&&(W.__webglDepthRenderbuffer=i.createRenderbuffer(),Sn(W.__webglDepthRenderbuffer,R,!0)),e.bindFramebuffer(i.FRAMEBUFFER,null)}}if(xt){e.bindTexture(i.TEXTURE_CUBE_MAP,ht.__webglTexture),de(i.TEXTURE_CUBE_MAP,v);for(let et=0;et<6;et++)if(v.mipmaps.length>0)for(let it=0;it<v.mipmaps.length;it++)Le(W.__webglFramebuffer[et][it],R,v,i.COLOR_ATTACHMENT0,i.TEXTURE_CUBE_MAP_POSITIVE_X+et,it);else Le(W.__webglFramebuffer[et],R,v,i.COLOR_ATTACHMENT0,i.TEXTURE_CUBE_MAP_POSITIVE_X+et,0);A(v)?w(i.TEXTURE_CUBE_MAP):v.mipmaps.length>0&&i.texParameteri(i.TEXTURE_CUBE_MAP,i.TEXTURE_MAX_LEVEL,v.mipmaps.length-1),e.unbindTexture()}else if(vt){for(let et=0,it=ot.length;et<it;et++){let pt=ot[et],U=n.get(pt),rt=i.TEXTURE_2D;(R.isWebGL3DRenderTarget||R.isWebGLArrayRenderTarget)&&(rt=R.isWebGL3DRenderTarget?i.TEXTURE_3D:i.TEXTURE_2D_ARRAY),e.bindTexture(rt,U.__webglTexture),de(rt,pt),Le(W.__webglFramebuffer,R,pt,i.COLOR_ATTACHMENT0+et,rt,0),A(pt)&&w(rt)}e.unbindTexture()}else{let et=i.TEXTURE_2D;if((R.isWebGL3DRenderTarget||R.isWebGLArrayRenderTarget)&&(et=R.isWebGL3DRenderTarget?i.TEXTURE_3D:i.TEXTURE_2D_ARRAY),e.bindTexture(et,ht.__webglTexture),de(et,v),v.mipmaps.length>0)for(let it=0;it<v.mipmaps.length;it++)Le(W.__webglFramebuffer[it],R,v,i.COLOR_ATTACHMENT0,et,it);else Le(W.__webglFramebuffer,R,v,i.COLOR_ATTACHMENT0,et,0);A(v)?w(et):v.mipmaps.length>0&&i.texParameteri(et,i.TEXTURE_MAX_LEVEL,v.mipmaps.length-1),e.unbindTexture()}R.depthBuffer&&gn(R)}function F(R){let v=R.textures;for(let W=0,ht=v.length;W<ht;W++){let ot=v[W];if(A(ot)&&ot.mipmapsAutoUpdate===!0){let xt=P(R),vt=n.get(ot).__webglTexture;e.bindTexture(xt,vt),w(xt),e.unbindTexture()}}}let Ct=[];function Zt(R){if(R.samples>0){if(Mt(R)===!1){let v=R.textures,W=R.width,ht=R.height,ot=i.COLOR_BUFFER_BIT,xt=R.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT,vt=n.get(R),et=v.length>1;if(et)for(let pt=0;pt<v.length;pt++)e.bindFramebuffer(i.FRAMEBUFFER,vt.__webglMultisampledFramebuffer),i.framebufferRenderbuffer(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0+pt,i.RENDERBUFFER,null),e.bindFramebuffer(i.FRAMEBUFFER,vt.__webglFramebuffer),i.framebufferTexture2D(i.DRAW_FRAMEBUFFER,i.COLOR_ATTACHMENT0+pt,i.TEXTURE_2D,null,0);e.bindFramebuffer(i.READ_FRAMEBUFFER,vt.__webglMultisampledFramebuffer),R.texture.mipmaps.length>0?e.bindFramebuffer(i.DRAW_FRAMEBUFFER,vt.__webglFramebuffer[0]):e.bindFramebuffer(i.DRAW_FRAMEBUFFER,vt.__webglFramebuffer);for(let pt=0;pt<v.length;pt++){if(R.resolveDepthBuffer&&(R.depthBuffer&&(ot|=i.DEPTH_BUFFER_BIT),R.stencilBuffer&&R.resolveStencilBuffer&&(ot|=i.STENCIL_BUFFER_BIT)),et){i.framebufferRenderbuffer(i.READ_FRAMEBUFFER,i.COLOR_ATTACHMENT0,i.RENDERBUFFER,vt.__webglColorRenderbuffer[pt]);let U=n.get(v[pt]).__webglTexture;i.framebufferTexture2D(i.DRAW_FRAMEBUFFER,i.COLOR_ATTACHMENT0,i.TEXTURE_2D,U,0)}i.blitFramebuffer(0,0,W,ht,0,0,W,ht,ot,i.NEAREST),l===!0&&(Ct.length=0,Ct.push(i.COLOR_ATTACHMENT0+pt),R.depthBuffer&&R.storeMultisampledDepthBuffer===!1&&Ct.push(xt),i.invalidateFramebuffer(i.READ_FRAMEBUFFER,Ct))}if(e.bindFramebuffer(i.READ_FRAMEBUFFER,null),e.bindFramebuffer(i.DRAW_FRAMEBUFFER,null),et)for(let pt=0;pt<v.length;pt++){e.bindFramebuffer(i.FRAMEBUFFER,vt.__webglMultisampledFramebuffer),i.framebufferRenderbuffer(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0+pt,i.RENDERBUFFER,vt.__webglColorRenderbuffer[pt]);let U=n.get(v[pt]).__webglTexture;e.bindFramebuffer(i.FRAMEBUFFER,vt.__webglFramebuffer),i.framebufferTexture2D(i.DRAW_FRAMEBUFFER,i.COLOR_ATTACHMENT0+pt,i.TEXTURE_2D,U,0)}e.bindFramebuffer(i.DRAW_FRAMEBUFFER,vt.__webglMultisampledFramebuffer)}else if(R.depthBuffer&&R.storeMultisampledDepthBuffer===!1&&l){let v=R.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT;i.invalidateFramebuffer(i.DRAW_FRAMEBUFFER,[v])}}}function ae(R){return Math.min(s.maxSamples,R.samples)}function Mt(R){let v=n.get(R);return R.samples>0&&t.has("WEBGL_multisampled_render_to_texture")===!0&&v.__useRenderToTexture!==!1}function Ue(R){let v=o.render.frame;h.get(R)!==v&&(h.set(R,v),R.update())}function zt(R,v){let W=R.colorSpace,ht=R.format,ot=R.type;return R.isCompressedTexture===!0||R.isVideoTexture===!0||W!==dr&&W!==vs&&(ge.getTransfer(W)===Re?(ht!==Ui||ot!==fi)&&jt("WebGLTextures: sRGB encoded textures have to use RGBAFormat and UnsignedByteType."):ne("WebGLTextures: Unsupported texture color space:",W)),v}function $t(R){return typeof HTMLImageElement<"u"&&R instanceof HTMLImageElement?(c.width=R.naturalWidth||R.width,c.height=R.naturalHeight||R.height):typeof VideoFrame<"u"&&R instanceof VideoFrame?(c.width=R.displayWidth,c.height=R.displayHeight):(c.width=R.width,c.height=R.height),c}this.allocateTextureUnit=ut,this.resetTextureUnits=Q,this.getTextureUnits=st,this.setTextureUnits=ft,this.setTexture2D=mt,this.setTexture2DArray=_t,this.setTexture3D=At,this.setTextureCube=St,this.rebindTextures=je,this.setupRenderTarget=ln,this.updateRenderTargetMipmap=F,this.updateMultisampleRenderTarget=Zt,this.setupDepthRenderbuffer=gn,this.setupFrameBufferTexture=Le,this.useMultisampledRTT=Mt,this.dispose=z}function HE(i,t){function e(n,s=vs){let r,o=ge.getTransfer(s);if(n===fi)return i.UNSIGNED_BYTE;if(n===Fc)return i.UNSIGNED_SHORT_4_4_4_4;if(n===Oc)return i.UNSIGNED_SHORT_5_5_5_1;if(n===Yf)return i.UNSIGNED_INT_5_9_9_9_REV;if(n===Zf)return i.UNSIGNED_INT_10F_11F_11F_REV;if(n===qf)return i.BYTE;if(n===$f)return i.SHORT;if(n===So)return i.UNSIGNED_SHORT;if(n===Uc)return i.INT;if(n===Li)return i.UNSIGNED_INT;if(n===Ni)return i.FLOAT;if(n===Di)return i.HALF_FLOAT;if(n===Jf)return i.ALPHA;if(n===Kf)return i.RGB;if(n===Ui)return i.RGBA;if(n===ms)return i.DEPTH_COMPONENT;if(n===_s)return i.DEPTH_STENCIL;if(n===jf)return i.RED;if(n===Bc)return i.RED_INTEGER;if(n===Ys)return i.RG;if(n===kc)return i.RG_INTEGER;if(n===zc)return i.RGBA_INTEGER;if(n===ya||n===ba||n===Sa||n===Ma)if(o===Re)if(r=t.get("WEBGL_compressed_texture_s3tc_srgb"),r!==null){if(n===ya)return r.COMPRESSED_SRGB_S3TC_DXT1_EXT;if(n===ba)return r.COMPRESSED_SRGB_ALPHA_S3TC_DXT1_EXT;if(n===Sa)return r.COMPRESSED_SRGB_ALPHA_S3TC_DXT3_EXT;if(n===Ma)return r.COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT}else return null;else if(r=t.get("WEBGL_compressed_texture_s3tc"),r!==null){if(n===ya)return r.COMPRESSED_RGB_S3TC_DXT1_EXT;if(n===ba)return r.COMPRESSED_RGBA_S3TC_DXT1_EXT;if(n===Sa)return r.COMPRESSED_RGBA_S3TC_DXT3_EXT;if(n===Ma)return r.COMPRESSED_RGBA_S3TC_DXT5_EXT}else return null;if(n===Vc||n===Hc||n===Gc||n===Wc)if(r=t.get("WEBGL_compressed_texture_pvrtc"),r!==null){if(n===Vc)return r.COMPRESSED_RGB_PVRTC_4BPPV1_IMG;if(n===Hc)return r.COMPRESSED_RGB_PVRTC_2BPPV1_IMG;if(n===Gc)return r.COMPRESSED_RGBA_PVRTC_4BPPV1_IMG;if(n===Wc)return r.COMPRESSED_RGBA_PVRTC_2BPPV1_IMG}else return null;if(n===Xc||n===qc||n===$c||n===Yc||n===Zc||n===wa||n===Jc)if(r=t.get("WEBGL_compressed_texture_etc"),r!==null){if(n===Xc||n===qc)return o===Re?r.COMPRESSED_SRGB8_ETC2:r.COMPRESSED_RGB8_ETC2;if(n===$c)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ETC2_EAC:r.COMPRESSED_RGBA8_ETC2_EAC;if(n===Yc)return r.COMPRESSED_R11_EAC;if(n===Zc)return r.COMPRESSED_SIGNED_R11_EAC;if(n===wa)return r.COMPRESSED_RG11_EAC;if(n===Jc)return r.COMPRESSED_SIGNED_RG11_EAC}else return null;if(n===Kc||n===jc||n===Qc||n===th||n===eh||n===nh||n===ih||n===sh||n===rh||n===oh||n===ah||n===lh||n===ch||n===hh)if(r=t.get("WEBGL_compressed_texture_astc"),r!==null){if(n===Kc)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_4x4_KHR:r.COMPRESSED_RGBA_ASTC_4x4_KHR;if(n===jc)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_5x4_KHR:r.COMPRESSED_RGBA_ASTC_5x4_KHR;if(n===Qc)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_5x5_KHR:r.COMPRESSED_RGBA_ASTC_5x5_KHR;if(n===th)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_6x5_KHR:r.COMPRESSED_RGBA_ASTC_6x5_KHR;if(n===eh)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_6x6_KHR:r.COMPRESSED_RGBA_ASTC_6x6_KHR;if(n===nh)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_8x5_KHR:r.COMPRESSED_RGBA_ASTC_8x5_KHR;if(n===ih)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_8x6_KHR:r.COMPRESSED_RGBA_ASTC_8x6_KHR;if(n===sh)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_8x8_KHR:r.COMPRESSED_RGBA_ASTC_8x8_KHR;if(n===rh)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_10x5_KHR:r.COMPRESSED_RGBA_ASTC_10x5_KHR;if(n===oh)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_10x6_KHR:r.COMPRESSED_RGBA_ASTC_10x6_KHR;if(n===ah)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_10x8_KHR:r.COMPRESSED_RGBA_ASTC_10x8_KHR;if(n===lh)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_10x10_KHR:r.COMPRESSED_RGBA_ASTC_10x10_KHR;if(n===ch)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_12x10_KHR:r.COMPRESSED_RGBA_ASTC_12x10_KHR;if(n===hh)return o===Re?r.COMPRESSED_SRGB8_ALPHA8_ASTC_12x12_KHR:r.COMPRESSED_RGBA_ASTC_12x12_KHR}else return null;if(n===uh||n===fh||n===dh)if(r=t.get("EXT_texture_compression_bptc"),r!==null){if(n===uh)return o===Re?r.COMPRESSED_SRGB_ALPHA_BPTC_UNORM_EXT:r.COMPRESSED_RGBA_BPTC_UNORM_EXT;if(n===fh)return r.COMPRESSED_RGB_BPTC_SIGNED_FLOAT_EXT;if(n===dh)return r.COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT_EXT}else return null;if(n===ph||n===mh||n===Ea||n===gh)if(r=t.get("EXT_texture_compression_rgtc"),r!==null){if(n===ph)return r.COMPRESSED_RED_RGTC1_EXT;if(n===mh)return r.COMPRESSED_SIGNED_RED_RGTC1_EXT;if(n===Ea)return r.COMPRESSED_RED_GREEN_RGTC2_EXT;if(n===gh)return r.COMPRESSED_SIGNED_RED_GREEN_RGTC2_EXT}else return null;return n===Sr?i.UNSIGNED_INT_24_8:i[n]!==void 0?i[n]:null}return{convert:e}}var GE=`
void main() {

	gl_Position = vec4( position, 1.0 );

}`,WE=`
uniform sampler2DArray depthColor;
uniform float depthWidth;
uniform float depthHeight;

void main() {

	vec2 coord = vec2( gl_FragCoord.x / depthWidth, gl_FragCoord.y / depthHeight );

	if ( coord.x >= 1.0 ) {

		gl_FragDepth = texture( depthColor, vec3( coord.x - 1.0, coord.y, 1 ) ).r;

	} else {

		gl_FragDepth = texture( depthColor, vec3( coord.x, coord.y, 0 ) ).r;

	}

}`,xd=class{constructor(){this.texture=null,this.mesh=null,this.depthNear=0,this.depthFar=0}init(t,e){if(this.texture===null){let n=new fa(t.texture);(t.depthNear!==e.depthNear||t.depthFar!==e.depthFar)&&(this.depthNear=t.depthNear,this.depthFar=t.depthFar),this.texture=n}}getMesh(t){if(this.texture!==null&&this.mesh===null){let e=t.cameras[0].viewport,n=new mn({vertexShader:GE,fragmentShader:WE,uniforms:{depthColor:{value:this.texture},depthWidth:{value:e.z},depthHeight:{value:e.w}}});this.mesh=new Cn(new da(20,20),n)}return this.mesh}reset(){this.texture=null,this.mesh=null}getDepthTexture(){return this.texture}},_d=class extends Zi{constructor(t,e){super();let n=this,s=null,r=1,o=null,a="local-floor",l=1,c=null,h=null,f=null,u=null,d=null,g=null,M=typeof XRWebGLBinding<"u",m=new xd,p={},y=e.getContextAttributes(),A=null,w=null,P=[],T=[],_=new Jt,E=null,V=null,D=new $n;D.viewport=new qe;let L=new $n;L.viewport=new qe;let H=[D,L],G=new Cc,N=null,z=null;this.cameraAutoUpdate=!0,this.enabled=!1,this.isPresenting=!1,this.getController=function(tt){let mt=P[tt];return mt===void 0&&(mt=new mo,P[tt]=mt),mt.getTargetRaySpace()},this.getControllerGrip=function(tt){let mt=P[tt];return mt===void 0&&(mt=new mo,P[tt]=mt),mt.getGripSpace()},this.getHand=function(tt){let mt=P[tt];return mt===void 0&&(mt=new mo,P[tt]=mt),mt.getHandSpace()};function J(tt){let mt=T.indexOf(tt.inputSource);if(mt===-1)return;let _t=P[mt];_t!==void 0&&(_t.update(tt.inputSource,tt.frame,c||o),_t.dispatchEvent({type:tt.type,data:tt.inputSource}))}function k(){s.removeEventListener("select",J),s.removeEventListener("selectstart",J),s.removeEventListener("selectend",J),s.removeEventListener("squeeze",J),s.removeEventListener("squeezestart",J),s.removeEventListener("squeezeend",J),s.removeEventListener("end",k),s.removeEventListener("inputsourceschange",ct);for(let tt=0;tt<P.length;tt++){let mt=T[tt];mt!==null&&(T[tt]=null,P[tt].disconnect(mt))}N=null,z=null,m.reset();for(let tt in p)delete p[tt];if(t.setRenderTarget(A),d=null,u=null,f=null,s=null,w=null,ut.stop(),n.isPresenting=!1,t.setPixelRatio(E),t.setSize(_.width,_.height,!1),V!==null){let tt=V.camera;tt.fov=V.fov,tt.zoom=V.zoom,tt.updateProjectionMatrix(),V=null}n.dispatchEvent({type:"sessionend"})}this.setFramebufferScaleFactor=function(tt){r=tt,n.isPresenting===!0&&jt("WebXRManager: Cannot change framebuffer scale while presenting.")},this.setReferenceSpaceType=function(tt){a=tt,n.isPresenting===!0&&jt("WebXRManager: Cannot change reference space type while presenting.")},this.getReferenceSpace=function(){return c||o},this.setReferenceSpace=function(tt){c=tt},this.getBaseLayer=function(){return u!==null?u:d},this.getBinding=function(){return f===null&&M&&(f=new XRWebGLBinding(s,e)),f},this.getFrame=function(){return g},this.getSession=function(){return s},this.setSession=async function(tt){if(s=tt,s!==null){if(A=t.getRenderTarget(),s.addEventListener("select",J),s.addEventListener("selectstart",J),s.addEventListener("selectend",J),s.addEventListener("squeeze",J),s.addEventListener("squeezestart",J),s.addEventListener("squeezeend",J),s.addEventListener("end",k),s.addEventListener("inputsourceschange",ct),y.xrCompatible!==!0&&await e.makeXRCompatible(),E=t.getPixelRatio(),t.getSize(_),M&&"createProjectionLayer"in XRWebGLBinding.prototype){let _t=null,At=null,St=null;y.depth&&(St=y.stencil?e.DEPTH24_STENCIL8:e.DEPTH_COMPONENT24,_t=y.stencil?_s:ms,At=y.stencil?Sr:Li);let Wt={colorFormat:e.RGBA8,depthFormat:St,scaleFactor:r};f=this.getBinding(),u=f.createProjectionLayer(Wt),s.updateRenderState({layers:[u]}),t.setPixelRatio(1),t.setSize(u.textureWidth,u.textureHeight,!1),w=new ci(u.textureWidth,u.textureHeight,{format:Ui,type:fi,depthTexture:new gs(u.textureWidth,u.textureHeight,At,void 0,void 0,void 0,void 0,void 0,void 0,_t),stencilBuffer:y.stencil,colorSpace:t.outputColorSpace,samples:y.antialias?4:0,resolveDepthBuffer:u.ignoreDepthValues===!1,resolveStencilBuffer:u.ignoreDepthValues===!1,storeMultisampledDepthBuffer:u.ignoreDepthValues===!1,storeMultisampledStencilBuffer:u.ignoreDepthValues===!1})}else{let _t={antialias:y.antialias,alpha:!0,depth:y.depth,stencil:y.stencil,framebufferScaleFactor:r};d=new XRWebGLLayer(s,e,_t),s.updateRenderState({baseLayer:d}),t.setPixelRatio(1),t.setSize(d.framebufferWidth,d.framebufferHeight,!1),w=new ci(d.framebufferWidth,d.framebufferHeight,{format:Ui,type:fi,colorSpace:t.outputColorSpace,stencilBuffer:y.stencil,resolveDepthBuffer:d.ignoreDepthValues===!1,resolveStencilBuffer:d.ignoreDepthValues===!1,storeMultisampledDepthBuffer:d.ignoreDepthValues===!1,storeMultisampledStencilBuffer:d.ignoreDepthValues===!1})}w.isXRRenderTarget=!0,this.setFoveation(l),c=null,o=await s.requestReferenceSpace(a),ut.setContext(s),ut.start(),n.isPresenting=!0,n.dispatchEvent({type:"sessionstart"})}},this.getEnvironmentBlendMode=function(){if(s!==null)return s.environmentBlendMode},this.getDepthTexture=function(){return m.getDepthTexture()};function ct(tt){for(let mt=0;mt<tt.removed.length;mt++){let _t=tt.removed[mt],At=T.indexOf(_t);At>=0&&(T[At]=null,P[At].disconnect(_t))}for(let mt=0;mt<tt.added.length;mt++){let _t=tt.added[mt],At=T.indexOf(_t);if(At===-1){for(let Wt=0;Wt<P.length;Wt++)if(Wt>=T.length){T.push(_t),At=Wt;break}else if(T[Wt]===null){T[Wt]=_t,At=Wt;break}if(At===-1)break}let St=P[At];St&&St.connect(_t)}}function K(tt,mt){mt===null?tt.matrixWorld.copy(tt.matrix):tt.matrixWorld.multiplyMatrices(mt.matrixWorld,tt.matrix),tt.matrixWorldInverse.copy(tt.matrixWorld).invert()}this.updateCamera=function(tt){if(s===null)return;let mt=tt.near,_t=tt.far;m.texture!==null&&(m.depthNear>0&&(mt=m.depthNear),m.depthFar>0&&(_t=m.depthFar)),G.near=L.near=D.near=mt,G.far=L.far=D.far=_t,(N!==G.near||z!==G.far)&&(s.updateRenderState({depthNear:G.near,depthFar:G.far}),N=G.near,z=G.far),G.layers.mask=tt.layers.mask|6,D.layers.mask=G.layers.mask&-5,L.layers.mask=G.layers.mask&-3;let At=tt.parent,St=G.cameras;K(G,At);for(let Wt=0;Wt<St.length;Wt++)K(St[Wt],At);G.projectionMatrix.copy(D.projectionMatrix),G.projectionMatrixInverse.copy(D.projectionMatrixInverse),V===null&&tt.isPerspectiveCamera&&(V={camera:tt,fov:tt.fov,zoom:tt.zoom}),Q(tt,G,At)};function Q(tt,mt,_t){_t===null?tt.matrix.copy(mt.matrixWorld):(tt.matrix.copy(_t.matrixWorld),tt.matrix.invert(),tt.matrix.multiply(mt.matrixWorld)),tt.matrix.decompose(tt.position,tt.quaternion,tt.scale),tt.updateMatrixWorld(!0),tt.projectionMatrix.copy(mt.projectionMatrix),tt.projectionMatrixInverse.copy(mt.projectionMatrixInverse),tt.isPerspectiveCamera&&(tt.fov=ac*2*Math.atan(1/tt.projectionMatrix.elements[5]),tt.zoom=1)}this.getCamera=function(){return G},this.getFoveation=function(){if(!(u===null&&d===null))return l},this.setFoveation=function(tt){l=tt,u!==null&&(u.fixedFoveation=tt),d!==null&&d.fixedFoveation!==void 0&&(d.fixedFoveation=tt)},this.hasDepthSensing=function(){return m.texture!==null},this.getDepthSensingMesh=function(){return m.getMesh(G)},this.getCameraTexture=function(tt){return p[tt]};let st=null;function ft(tt,mt){if(h=mt.getViewerPose(c||o),g=mt,h!==null){let _t=h.views;d!==null&&(t.setRenderTargetFramebuffer(w,d.framebuffer),t.setRenderTarget(w));let At=!1;_t.length!==G.cameras.length&&(G.cameras.length=0,At=!0);for(let Vt=0;Vt<_t.length;Vt++){let de=_t[Vt],he=null;if(d!==null)he=d.getViewport(de);else{let $e=f.getViewSubImage(u,de);he=$e.viewport,Vt===0&&(t.setRenderTargetTextures(w,$e.colorTexture,$e.depthStencilTexture),t.setRenderTarget(w))}let se=H[Vt];se===void 0&&(se=new $n,se.layers.enable(Vt),se.viewport=new qe,H[Vt]=se),se.matrix.fromArray(de.transform.matrix),se.matrix.decompose(se.position,se.quaternion,se.scale),se.projectionMatrix.fromArray(de.projectionMatrix),se.projectionMatrixInverse.copy(se.projectionMatrix).invert(),se.viewport.set(he.x,he.y,he.width,he.height),Vt===0&&(G.matrix.copy(se.matrix),G.matrix.decompose(G.position,G.quaternion,G.scale)),At===!0&&G.cameras.push(se)}let St=s.enabledFeatures;if(St&&St.includes("depth-sensing")&&s.depthUsage=="gpu-optimized"&&M){f=n.getBinding();let Vt=f.getDepthInformation(_t[0]);Vt&&Vt.isValid&&Vt.texture&&m.init(Vt,s.renderState)}if(St&&St.includes("camera-access")&&M){t.state.unbindTexture(),f=n.getBinding();for(let Vt=0;Vt<_t.length;Vt++){let de=_t[Vt].camera;if(de){let he=p[de];he||(he=new fa,p[de]=he);let se=f.getCameraImage(de);he.sourceTexture=se}}}}for(let _t=0;_t<P.length;_t++){let At=T[_t],St=P[_t];At!==null&&St!==void 0&&St.update(At,mt,c||o)}st&&st(tt,mt),mt.detectedPlanes&&n.dispatchEvent({type:"planesdetected",data:mt}),g=null}let ut=new Y0;ut.setAnimationLoop(ft),this.setAnimationLoop=function(tt){st=tt},this.dispose=function(){}}},XE=new Ke,sx=new ie;sx.set(-1,0,0,0,1,0,0,0,1);function qE(i,t){function e(m,p){m.matrixAutoUpdate===!0&&m.updateMatrix(),p.value.copy(m.matrix)}function n(m,p){p.color.getRGB(m.fogColor.value,rd(i)),p.isFog?(m.fogNear.value=p.near,m.fogFar.value=p.far):p.isFogExp2&&(m.fogDensity.value=p.density)}function s(m,p,y,A,w){p.isNodeMaterial?p.uniformsNeedUpdate=!1:p.isMeshBasicMaterial?r(m,p):p.isMeshLambertMaterial?(r(m,p),p.envMap&&(m.envMapIntensity.value=p.envMapIntensity)):p.isMeshToonMaterial?(r(m,p),f(m,p)):p.isMeshPhongMaterial?(r(m,p),h(m,p),p.envMap&&(m.envMapIntensity.value=p.envMapIntensity)):p.isMeshStandardMaterial?(r(m,p),u(m,p),p.isMeshPhysicalMaterial&&d(m,p,w)):p.isMeshMatcapMaterial?(r(m,p),g(m,p)):p.isMeshDepthMaterial?r(m,p):p.isMeshDistanceMaterial?(r(m,p),M(m,p)):p.isMeshNormalMaterial?r(m,p):p.isLineBasicMaterial?(o(m,p),p.isLineDashedMaterial&&a(m,p)):p.isPointsMaterial?l(m,p,y,A):p.isSpriteMaterial?c(m,p):p.isShadowMaterial?(m.color.value.copy(p.color),m.opacity.value=p.opacity):p.isShaderMaterial&&(p.uniformsNeedUpdate=!1)}function r(m,p){m.opacity.value=p.opacity,p.color&&m.diffuse.value.copy(p.color),p.emissive&&m.emissive.value.copy(p.emissive).multiplyScalar(p.emissiveIntensity),p.map&&(m.map.value=p.map,e(p.map,m.mapTransform)),p.alphaMap&&(m.alphaMap.value=p.alphaMap,e(p.alphaMap,m.alphaMapTransform)),p.bumpMap&&(m.bumpMap.value=p.bumpMap,e(p.bumpMap,m.bumpMapTransform),m.bumpScale.value=p.bumpScale,p.side===Kn&&(m.bumpScale.value*=-1)),p.normalMap&&(m.normalMap.value=p.normalMap,e(p.normalMap,m.normalMapTransform),m.normalScale.value.copy(p.normalScale),p.side===Kn&&m.normalScale.value.negate()),p.displacementMap&&(m.displacementMap.value=p.displacementMap,e(p.displacementMap,m.displacementMapTransform),m.displacementScale.value=p.displacementScale,m.displacementBias.value=p.displacementBias),p.emissiveMap&&(m.emissiveMap.value=p.emissiveMap,e(p.emissiveMap,m.emissiveMapTransform)),p.specularMap&&(m.specularMap.value=p.specularMap,e(p.specularMap,m.specularMapTransform)),p.alphaTest>0&&(m.alphaTest.value=p.alphaTest);let y=t.get(p),A=y.envMap,w=y.envMapRotation;A&&(m.envMap.value=A,m.envMapRotation.value.setFromMatrix4(XE.makeRotationFromEuler(w)).transpose(),A.isCubeTexture&&A.isRenderTargetTexture===!1&&m.envMapRotation.value.premultiply(sx),m.reflectivity.value=p.reflectivity,m.ior.value=p.ior,m.refractionRatio.value=p.refractionRatio),p.lightMap&&(m.lightMap.value=p.lightMap,m.lightMapIntensity.value=p.lightMapIntensity,e(p.lightMap,m.lightMapTransform)),p.aoMap&&(m.aoMap.value=p.aoMap,m.aoMapIntensity.value=p.aoMapIntensity,e(p.aoMap,m.aoMapTransform))}function o(m,p){m.diffuse.value.copy(p.color),m.opacity.value=p.opacity,p.map&&(m.map.value=p.map,e(p.map,m.mapTransform))}function a(m,p){m.dashSize.value=p.dashSize,m.totalSize.value=p.dashSize+p.gapSize,m.scale.value=p.scale}function l(m,p,y,A){m.diffuse.value.copy(p.color),m.opacity.value=p.opacity,m.size.value=p.size*y,m.scale.value=A*.5,p.map&&(m.map.value=p.map,e(p.map,m.uvTransform)),p.alphaMap&&(m.alphaMap.value=p.alphaMap,e(p.alphaMap,m.alphaMapTransform)),p.alphaTest>0&&(m.alphaTest.value=p.alphaTest)}function c(m,p){m.diffuse.value.copy(p.color),m.opacity.value=p.opacity,m.rotation.value=p.rotation,p.map&&(m.map.value=p.map,e(p.map,m.mapTransform)),p.alphaMap&&(m.alphaMap.value=p.alphaMap,e(p.alphaMap,m.alphaMapTransform)),p.alphaTest>0&&(m.alphaTest.value=p.alphaTest)}function h(m,p){m.specular.value.copy(p.specular),m.shininess.value=Math.max(p.shininess,1e-4)}function f(m,p){p.gradientMap&&(m.gradientMap.value=p.gradientMap)}function u(m,p){m.metalness.value=p.metalness,p.metalnessMap&&(m.metalnessMap.value=p.metalnessMap,e(p.metalnessMap,m.metalnessMapTransform)),m.roughness.value=p.roughness,p.roughnessMap&&(m.roughnessMap.value=p.roughnessMap,e(p.roughnessMap,m.roughnessMapTransform)),p.envMap&&(m.envMapIntensity.value=p.envMapIntensity)}function d(m,p,y){m.ior.value=p.ior,p.diffuseRoughness>0&&(m.diffuseRoughness.value=p.diffuseRoughness,p.diffuseRoughnessMap&&(m.diffuseRoughnessMap.value=p.diffuseRoughnessMap,e(p.diffuseRoughnessMap,m.diffuseRoughnessMapTransform))),p.sheen>0&&(m.sheenColor.value.copy(p.sheenColor).multiplyScalar(p.sheen),m.sheenRoughness.value=p.sheenRoughness,p.sheenColorMap&&(m.sheenColorMap.value=p.sheenColorMap,e(p.sheenColorMap,m.sheenColorMapTransform)),p.sheenRoughnessMap&&(m.sheenRoughnessMap.value=p.sheenRoughnessMap,e(p.sheenRoughnessMap,m.sheenRoughnessMapTransform))),p.clearcoat>0&&(m.clearcoat.value=p.clearcoat,m.clearcoatRoughness.value=p.clearcoatRoughness,p.clearcoatMap&&(m.clearcoatMap.value=p.clearcoatMap,e(p.clearcoatMap,m.clearcoatMapTransform)),p.clearcoatRoughnessMap&&(m.clearcoatRoughnessMap.value=p.clearcoatRoughnessMap,e(p.clearcoatRoughnessMap,m.clearcoatRoughnessMapTransform)),p.clearcoatNormalMap&&(m.clearcoatNormalMap.value=p.clearcoatNormalMap,e(p.clearcoatNormalMap,m.clearcoatNormalMapTransform),m.clearcoatNormalScale.value.copy(p.clearcoatNormalScale),p.side===Kn&&m.clearcoatNormalScale.value.negate())),p.dispersion>0&&(m.dispersion.value=p.dispersion),p.retroreflectivity>0&&(m.retroreflectivity.value=p.retroreflectivity),p.iridescence>0&&(m.iridescence.value=p.iridescence,m.iridescenceIOR.value=p.iridescenceIOR,m.iridescenceThicknessMinimum.value=p.iridescenceThicknessMinimum,m.iridescenceThicknessMaximum.value=p.iridescenceThicknessMaximum,p.iridescenceMap&&(m.iridescenceMap.value=p.iridescenceMap,e(p.iridescenceMap,m.iridescenceMapTransform)),p.iridescenceThicknessMap&&(m.iridescenceThicknessMap.value=p.iridescenceThicknessMap,e(p.iridescenceThicknessMap,m.iridescenceThicknessMapTransform))),p.transmission>0&&(m.transmission.value=p.transmission,m.transmissionSamplerMap.value=y.texture,m.transmissionSamplerSize.value.set(y.width,y.height),p.transmissionMap&&(m.transmissionMap.value=p.transmissionMap,e(p.transmissionMap,m.transmissionMapTransform)),m.thickness.value=p.thickness,p.thicknessMap&&(m.thicknessMap.value=p.thicknessMap,e(p.thicknessMap,m.thicknessMapTransform)),m.attenuationDistance.value=p.attenuationDistance,m.attenuationColor.value.copy(p.attenuationColor)),p.anisotropy>0&&(m.anisotropyVector.value.set(p.anisotropy*Math.cos(p.anisotropyRotation),p.anisotropy*Math.sin(p.anisotropyRotation)),p.anisotropyMap&&(m.anisotropyMap.value=p.anisotropyMap,e(p.anisotropyMap,m.anisotropyMapTransform))),m.specularIntensity.value=p.specularIntensity,m.specularColor.value.copy(p.specularColor),p.specularColorMap&&(m.specularColorMap.value=p.specularColorMap,e(p.specularColorMap,m.specularColorMapTransform)),p.specularIntensityMap&&(m.specularIntensityMap.value=p.specularIntensityMap,e(p.specularIntensityMap,m.specularIntensityMapTransform))}function g(m,p){p.matcap&&(m.matcap.value=p.matcap)}function M(m,p){let y=t.get(p).light;m.referencePosition.value.setFromMatrixPosition(y.matrixWorld),m.nearDistance.value=y.shadow.camera.near,m.farDistance.value=y.shadow.camera.far}return{refreshFogUniforms:n,refreshMaterialUniforms:s}}function $E(i,t,e,n){let s={},r={};function o(y,A){let w=A.program;n.uniformBlockBinding(y,w,s[y.id])}function a(y,A){let w=s[y.id];w===void 0&&(g(y),w=l(y),s[y.id]=w,y.addEventListener("dispose",m));let P=A.program;n.updateUBOMapping(y,P);let T=t.render.frame;r[y.id]!==T&&(c(y),r[y.id]=T)}function l(y){let A=i.createBuffer(),w=y.__size,P=y.usage;return i.bindBuffer(i.UNIFORM_BUFFER,A),i.bufferData(i.UNIFORM_BUFFER,w,P),i.bindBuffer(i.UNIFORM_BUFFER,null),A}function c(y){let A=s[y.id],w=y.uniforms,P=y.__cache;i.bindBuffer(i.UNIFORM_BUFFER,A);for(let T=0,_=w.length;T<_;T++){let E=w[T];if(Array.isArray(E))for(let V=0,D=E.length;V<D;V++)h(E[V],T,V,P);else h(E,T,0,P)}i.bindBuffer(i.UNIFORM_BUFFER,null)}function h(y,A,w,P){if(u(y,A,w,P)===!0){let T=y.__offset,_=y.value;if(Array.isArray(_)){let E=0;for(let V=0;V<_.length;V++){let D=_[V],L=M(D,!0);f(D,y.__data,E),E+=L.storage/Float32Array.BYTES_PER_ELEMENT}}else f(_,y.__data,0);i.bufferSubData(i.UNIFORM_BUFFER,T,y.__data)}}function f(y,A,w){typeof y=="number"||typeof y=="boolean"?A[w]=y:y.isMatrix3?(A[w]=y.elements[0],A[w+1]=y.elements[1],A[w+2]=y.elements[2],A[w+3]=0,A[w+4]=y.elements[3],A[w+5]=y.elements[4],A[w+6]=y.elements[5],A[w+7]=0,A[w+8]=y.elements[6],A[w+9]=y.elements[7],A[w+10]=y.elements[8],A[w+11]=0):ArrayBuffer.isView(y)?A.set(y.subarray(0,A.length-w),w):y.toArray(A,w)}function u(y,A,w,P){let T=y.value,_=A+"_"+w;if(Array.isArray(T)){P[_]===void 0&&(P[_]=[]);let E=P[_],V=!1;for(let D=0;D<T.length;D++)d(T[D],E,D)===!0&&(V=!0);return V}return d(T,P,_)}function d(y,A,w){if(A[w]===void 0)return typeof y=="number"||typeof y=="boolean"?A[w]=y:ArrayBuffer.isView(y)?A[w]=y.slice():A[w]=y.clone(),!0;{let P=A[w];if(typeof y=="number"||typeof y=="boolean"){if(P!==y)return A[w]=y,!0}else{if(ArrayBuffer.isView(y))return!0;if(P.equals(y)===!1)return P.copy(y),!0}}return!1}function g(y){let A=y.uniforms,w=0,P=16;for(let _=0,E=A.length;_<E;_++){let V=Array.isArray(A[_])?A[_]:[A[_]];for(let D=0,L=V.length;D<L;D++){let H=V[D],G=Array.isArray(H.value)?H.value:[H.value],N=Array.isArray(A[_])||Array.isArray(H.value),z=w;for(let k=0,ct=G.length;k<ct;k++){let K=G[k],Q=M(K,N),st=w%P,ft=st%Q.boundary,ut=st+ft;w+=ft,ut!==0&&P-ut<Q.storage&&(w+=P-ut),k===0&&(z=w),w+=Q.storage}let J=H.type==="int"?Int32Array:H.type==="uint"?Uint32Array:Float32Array;H.__data=new J((w-z)/Float32Array.BYTES_PER_ELEMENT),H.__offset=z}}let T=w%P;return T>0&&(w+=P-T),y.__size=w,y.__cache={},this}function M(y,A){let w={boundary:0,storage:0};return typeof y=="number"||typeof y=="boolean"?(w.boundary=4,w.storage=4):y.isVector2?(w.boundary=8,w.storage=8):y.isVector3||y.isColor?(w.boundary=16,w.storage=12):y.isVector4?(w.boundary=16,w.storage=16):y.isMatrix3?(w.boundary=16,w.storage=48):y.isMatrix4?(w.boundary=16,w.storage=64):y.isTexture?jt("WebGLRenderer: Texture samplers can not be part of an uniforms group."):ArrayBuffer.isView(y)?(w.boundary=16,w.storage=y.byteLength):jt("WebGLRenderer: Unsupported uniform value type.",y),A===!0&&(w.boundary=16,w.storage=Math.ceil(w.storage/16)*16),w}function m(y){let A=y.target;A.removeEventListener("dispose",m),i.deleteBuffer(s[A.id]),delete s[A.id],delete r[A.id]}function p(){for(let y in s)i.deleteBuffer(s[y]);s={},r={}}return{bind:o,update:a,dispose:p}}var YE=new Uint16Array([12469,15057,12620,14925,13266,14620,13807,14376,14323,13990,14545,13625,14713,13328,14840,12882,14931,12528,14996,12233,15039,11829,15066,11525,15080,11295,15085,10976,15082,10705,15073,10495,13880,14564,13898,14542,13977,14430,14158,14124,14393,13732,14556,13410,14702,12996,14814,12596,14891,12291,14937,11834,14957,11489,14958,11194,14943,10803,14921,10506,14893,10278,14858,9960,14484,14039,14487,14025,14499,13941,14524,13740,14574,13468,14654,13106,14743,12678,14818,12344,14867,11893,14889,11509,14893,11180,14881,10751,14852,10428,14812,10128,14765,9754,14712,9466,14764,13480,14764,13475,14766,13440,14766,13347,14769,13070,14786,12713,14816,12387,14844,11957,14860,11549,14868,11215,14855,10751,14825,10403,14782,10044,14729,9651,14666,9352,14599,9029,14967,12835,14966,12831,14963,12804,14954,12723,14936,12564,14917,12347,14900,11958,14886,11569,14878,11247,14859,10765,14828,10401,14784,10011,14727,9600,14660,9289,14586,8893,14508,8533,15111,12234,15110,12234,15104,12216,15092,12156,15067,12010,15028,11776,14981,11500,14942,11205,14902,10752,14861,10393,14812,9991,14752,9570,14682,9252,14603,8808,14519,8445,14431,8145,15209,11449,15208,11451,15202,11451,15190,11438,15163,11384,15117,11274,15055,10979,14994,10648,14932,10343,14871,9936,14803,9532,14729,9218,14645,8742,14556,8381,14461,8020,14365,7603,15273,10603,15272,10607,15267,10619,15256,10631,15231,10614,15182,10535,15118,10389,15042,10167,14963,9787,14883,9447,14800,9115,14710,8665,14615,8318,14514,7911,14411,7507,14279,7198,15314,9675,15313,9683,15309,9712,15298,9759,15277,9797,15229,9773,15166,9668,15084,9487,14995,9274,14898,8910,14800,8539,14697,8234,14590,7790,14479,7409,14367,7067,14178,6621,15337,8619,15337,8631,15333,8677,15325,8769,15305,8871,15264,8940,15202,8909,15119,8775,15022,8565,14916,8328,14804,8009,14688,7614,14569,7287,14448,6888,14321,6483,14088,6171,15350,7402,15350,7419,15347,7480,15340,7613,15322,7804,15287,7973,15229,8057,15148,8012,15046,7846,14933,7611,14810,7357,14682,7069,14552,6656,14421,6316,14251,5948,14007,5528,15356,5942,15356,5977,15353,6119,15348,6294,15332,6551,15302,6824,15249,7044,15171,7122,15070,7050,14949,6861,14818,6611,14679,6349,14538,6067,14398,5651,14189,5311,13935,4958,15359,4123,15359,4153,15356,4296,15353,4646,15338,5160,15311,5508,15263,5829,15188,6042,15088,6094,14966,6001,14826,5796,14678,5543,14527,5287,14377,4985,14133,4586,13869,4257,15360,1563,15360,1642,15358,2076,15354,2636,15341,3350,15317,4019,15273,4429,15203,4732,15105,4911,14981,4932,14836,4818,14679,4621,14517,4386,14359,4156,14083,3795,13808,3437,15360,122,15360,137,15358,285,15355,636,15344,1274,15322,2177,15281,2765,15215,3223,15120,3451,14995,3569,14846,3567,14681,3466,14511,3305,14344,3121,14037,2800,13753,2467,15360,0,15360,1,15359,21,15355,89,15346,253,15325,479,15287,796,15225,1148,15133,1492,15008,1749,14856,1882,14685,1886,14506,1783,14324,1608,13996,1398,13702,1183]),Qi=null;function ZE(){return Qi===null&&(Qi=new go(YE,16,16,Ys,Di),Qi.name="DFG_LUT",Qi.minFilter=Zn,Qi.magFilter=Zn,Qi.wrapS=Yi,Qi.wrapT=Yi,Qi.generateMipmaps=!1,Qi.needsUpdate=!0),Qi}var bh=class{constructor(t={}){let{canvas:e=g0(),context:n=null,depth:s=!0,stencil:r=!1,alpha:o=!1,antialias:a=!1,premultipliedAlpha:l=!0,preserveDrawingBuffer:c=!1,powerPreference:h="default",failIfMajorPerformanceCaveat:f=!1,reversedDepthBuffer:u=!1,outputBufferType:d=fi}=t;this.isWebGLRenderer=!0;let g;if(n!==null){if(typeof WebGLRenderingContext<"u"&&n instanceof WebGLRenderingContext)throw new Error("THREE.WebGLRenderer: WebGL 1 is not supported since r163.");g=n.getContextAttributes().alpha}else g=o;let M=d,m=new Set([zc,kc,Bc]),p=new Set([fi,Li,So,Sr,Fc,Oc]),y=new Uint32Array(4),A=new Int32Array(4),w={textures:[],min:[],max:[],resolution:[]},P=null,T=null,_=[],E=[],V=null;this.domElement=e,this.debug={checkShaderErrors:!0,diagnostics:{keywords:!1},onShaderError:null},this.autoClear=!0,this.autoClearColor=!0,this.autoClearDepth=!0,this.autoClearStencil=!0,this.sortObjects=!0,this.clippingPlanes=[],this.localClippingEnabled=!1,this.toneMapping=ji,this.toneMappingExposure=1,this.transmissionResolutionScale=1;let D=this,L=!1,H=null,G=null,N=null,z=null;this._outputColorSpace=li;let J=0,k=0,ct=null,K=-1,Q=null,st=new qe,ft=new qe,ut=null,tt=new Yt(0),mt=0,_t=e.width,At=e.height,St=1,Wt=null,oe=null,Vt=new qe(0,0,_t,At),de=new qe(0,0,_t,At),he=!1,se=new gr,$e=new dc,Be=!1,an=!1,Le=new Ke,Sn=new q,be=new qe,gn={background:null,fog:null,environment:null,overrideMaterial:null,isScene:!0},je=!1;function ln(){return ct===null?St:1}let F=n;function Ct(S,O){return e.getContext(S,O)}let Zt,ae,Mt,Ue,zt,$t,R,v,W,ht,ot,xt,vt,et,it,pt,U,rt,nt,wt,gt,bt,Ht;try{let S={alpha:!0,depth:s,stencil:r,antialias:a,premultipliedAlpha:l,preserveDrawingBuffer:c,powerPreference:h,failIfMajorPerformanceCaveat:f};if("setAttribute"in e&&e.setAttribute("data-engine",`three.js r${"187"}`),e.addEventListener("webglcontextlost",Ot,!1),e.addEventListener("webglcontextrestored",te,!1),e.addEventListener("webglcontextcreationerror",Rt,!1),F===null){let O="webgl2";if(F=Ct(O,S),F===null)throw Ct(O)?new Error("THREE.WebGLRenderer: Error creating WebGL context with your selected attributes."):new Error("THREE.WebGLRenderer: Error creating WebGL context.")}Qt()}catch(S){throw e.removeEventListener("webglcontextlost",Ot,!1),e.removeEventListener("webglcontextrestored",te,!1),e.removeEventListener("webglcontextcreationerror",Rt,!1),ne("WebGLRenderer: "+S.message),S}function Qt(){Zt=new ow(F),Zt.init(),gt=new HE(F,Zt),ae=new Z1(F,Zt,t,gt),Mt=new zE(F,Zt),ae.reversedDepthBuffer&&u&&Mt.buffers.depth.setReversed(!0),G=F.createFramebuffer(),N=F.createFramebuffer(),z=F.createFramebuffer(),Ue=new cw(F),zt=new TE,$t=new VE(F,Zt,Mt,zt,ae,gt,Ue),R=new rw(D),v=new uS(F),bt=new $1(F,v),W=new aw(F,v,Ue,bt),ht=new uw(F,W,v,bt,Ue),rt=new hw(F,ae,$t),it=new J1(zt),ot=new EE(D,R,Zt,ae,bt,it),xt=new qE(D,zt),vt=new RE,et=new DE(Zt),U=new q1(D,R,Mt,ht,g,l),pt=new kE(D,ht,ae),Ht=new $E(F,Ue,ae,Mt),nt=new Y1(F,Zt,Ue),wt=new lw(F,Zt,Ue),Ue.programs=ot.programs,D.capabilities=ae,D.extensions=Zt,D.properties=zt,D.renderLists=vt,D.shadowMap=pt,D.state=Mt,D.info=Ue}M!==fi&&(V=new dw(M,e.width,e.height,a,s,r));let lt=new _d(D,F);this.xr=lt,this.getContext=function(){return F},this.getContextAttributes=function(){return F.getContextAttributes()},this.forceContextLoss=function(){let S=Zt.get("WEBGL_lose_context");S&&S.loseContext()},this.forceContextRestore=function(){let S=Zt.get("WEBGL_lose_context");S&&S.restoreContext()},this.getPixelRatio=function(){return St},this.setPixelRatio=function(S){S!==void 0&&(St=S,this.setSize(_t,At,!1))},this.getSize=function(S){return S.set(_t,At)},this.setSize=function(S,O,j=!0){if(lt.isPresenting){jt("WebGLRenderer: Can't change size while VR device is presenting.");return}_t=S,At=O,e.width=Math.floor(S*St),e.height=Math.floor(O*St),j===!0&&(e.style.width=S+"px",e.style.height=O+"px"),V!==null&&V.setSize(e.width,e.height),this.setViewport(0,0,S,O)},this.getDrawingBufferSize=function(S){return S.set(_t*St,At*St).floor()},this.setDrawingBufferSize=function(S,O,j){_t=S,At=O,St=j,e.width=Math.floor(S*j),e.height=Math.floor(O*j),this.setViewport(0,0,S,O)},this.setEffects=function(S){if(M===fi){ne("WebGLRenderer: setEffects() requires outputBufferType set to HalfFloatType or FloatType.");return}if(S){for(let O=0;O<S.length;O++)if(S[O].isOutputPass===!0){jt("WebGLRenderer: OutputPass is not needed in setEffects(). Tone mapping and color space conversion are applied automatically.");break}}V.setEffects(S||[])},this.getCurrentViewport=function(S){return S.copy(st)},this.getViewport=function(S){return S.copy(Vt)},this.setViewport=function(S,O,j,$){S.isVector4?Vt.set(S.x,S.y,S.z,S.w):Vt.set(S,O,j,$),Mt.viewport(st.copy(Vt).multiplyScalar(ln()).round())},this.getScissor=function(S){return S.copy(de)},this.setScissor=function(S,O,j,$){S.isVector4?de.set(S.x,S.y,S.z,S.w):de.set(S,O,j,$),Mt.scissor(ft.copy(de).multiplyScalar(ln()).round())},this.getScissorTest=function(){return he},this.setScissorTest=function(S){Mt.setScissorTest(he=S)},this.setOpaqueSort=function(S){Wt=S},this.setTransparentSort=function(S){oe=S},this.getClearColor=function(S){return S.copy(U.getClearColor())},this.setClearColor=function(){U.setClearColor(...arguments)},this.getClearAlpha=function(){return U.getClearAlpha()},this.setClearAlpha=function(){U.setClearAlpha(...arguments)},this.clear=function(S=!0,O=!0,j=!0){let $=0;if(S){let Y=!1;if(ct!==null){let Et=ct.texture.format;Y=m.has(Et)}if(Y){let Et=ct.texture.type,Pt=p.has(Et),Tt=U.getClearColor(),It=U.getClearAlpha(),kt=Tt.r,ee=Tt.g,pe=Tt.b;Pt?(y[0]=kt,y[1]=ee,y[2]=pe,y[3]=It,F.clearBufferuiv(F.COLOR,0,y)):(A[0]=kt,A[1]=ee,A[2]=pe,A[3]=It,F.clearBufferiv(F.COLOR,0,A))}else $|=F.COLOR_BUFFER_BIT}O&&($|=F.DEPTH_BUFFER_BIT,this.state.buffers.depth.setMask(!0)),j&&($|=F.STENCIL_BUFFER_BIT,this.state.buffers.stencil.setMask(4294967295)),$!==0&&F.clear($)},this.clearColor=function(){this.clear(!0,!1,!1)},this.clearDepth=function(){this.clear(!1,!0,!1)},this.clearStencil=function(){this.clear(!1,!1,!0)},this.setNodesHandler=function(S){S.setRenderer(this),H=S},this.dispose=function(){e.removeEventListener("webglcontextlost",Ot,!1),e.removeEventListener("webglcontextrestored",te,!1),e.removeEventListener("webglcontextcreationerror",Rt,!1),U.dispose(),vt.dispose(),et.dispose(),$t.dispose(),zt.dispose(),R.dispose(),ht.dispose(),W.dispose(),bt.dispose(),Ht.dispose(),ot.dispose(),lt.dispose(),lt.removeEventListener("sessionstart",Ua),lt.removeEventListener("sessionend",Oi),ns.stop()};function Ot(S){S.preventDefault(),ea("WebGLRenderer: Context Lost."),L=!0}function te(){ea("WebGLRenderer: Context Restored."),L=!1;let S=Ue.autoReset,O=pt.enabled,j=pt.autoUpdate,$=pt.needsUpdate,Y=pt.type;Qt(),Ue.autoReset=S,pt.enabled=O,pt.autoUpdate=j,pt.needsUpdate=$,pt.type=Y}function Rt(S){ne("WebGLRenderer: A WebGL context could not be created. Reason: ",S.statusMessage)}function ce(S){let O=S.target;O.removeEventListener("dispose",ce),ze(O)}function ze(S){kn(S),zt.remove(S)}function kn(S){let O=zt.get(S).programs;O!==void 0&&(O.forEach(function(j){ot.releaseProgram(j)}),S.isShaderMaterial&&ot.releaseShaderCache(S))}this.renderBufferDirect=function(S,O,j,$,Y,Et){O===null&&(O=gn);let Pt=Y.isMesh&&Y.matrixWorld.determinantAffine()<0,Tt=Po(S,O,j,$,Y);Mt.setMaterial($,Pt);let It=j.index,kt=1;if($.wireframe===!0){if(It=W.getWireframeAttribute(j),It===void 0)return;kt=2}let ee=j.drawRange,pe=j.attributes.position,Bt=ee.start*kt,me=(ee.start+ee.count)*kt;Et!==null&&(Bt=Math.max(Bt,Et.start*kt),me=Math.min(me,(Et.start+Et.count)*kt)),It!==null?(Bt=Math.max(Bt,0),me=Math.min(me,It.count)):pe!=null&&(Bt=Math.max(Bt,0),me=Math.min(me,pe.count));let Je=me-Bt;if(Je<0||Je===1/0)return;bt.setup(Y,$,Tt,j,It);let Ce,Pe=nt;if(It!==null&&(Ce=v.get(It),Pe=wt,Pe.setIndex(Ce)),Y.isMesh)$.wireframe===!0?(Mt.setLineWidth($.wireframeLinewidth*ln()),Pe.setMode(F.LINES)):Pe.setMode(F.TRIANGLES);else if(Y.isLine){let xn=$.linewidth;xn===void 0&&(xn=1),Mt.setLineWidth(xn*ln()),Y.isLineSegments?Pe.setMode(F.LINES):Y.isLineLoop?Pe.setMode(F.LINE_LOOP):Pe.setMode(F.LINE_STRIP)}else Y.isPoints?Pe.setMode(F.POINTS):Y.isSprite&&Pe.setMode(F.TRIANGLES);if(Y.isBatchedMesh)if(Zt.get("WEBGL_multi_draw"))Pe.renderMultiDraw(Y._multiDrawStarts,Y._multiDrawCounts,Y._multiDrawCount);else{let xn=Y._multiDrawStarts,Ut=Y._multiDrawCounts,cn=Y._multiDrawCount,_e=It?v.get(It).bytesPerElement:1,ss=zt.get($).currentProgram.getUniforms();for(let hn=0;hn<cn;hn++)ss.setValue(F,"_gl_DrawID",hn),Pe.render(xn[hn]/_e,Ut[hn])}else if(Y.isInstancedMesh)Pe.renderInstances(Bt,Je,Y.count);else if(j.isInstancedBufferGeometry){let xn=j._maxInstanceCount!==void 0?j._maxInstanceCount:1/0,Ut=Math.min(j.instanceCount,xn);Pe.renderInstances(Bt,Je,Ut)}else Pe.render(Bt,Je)};function Ao(S,O,j,$){H!==null&&S.isNodeMaterial&&H.setObject($,S),Be===!0&&it.setState(S,j,!1),S.transparent===!0&&S.side===On&&S.forceSinglePass===!1?(S.side=Kn,S.needsUpdate=!0,Bi(S,O,$),S.side=$s,S.needsUpdate=!0,Bi(S,O,$),S.side=On):Bi(S,O,$)}this.compile=function(S,O,j=null){j===null&&(j=S),H!==null&&H.renderStart(S,O,j),T=et.get(j),T.init(O),E.push(T),j.traverseVisible(function(Y){Y.isLight&&Y.layers.test(O.layers)&&(T.pushLight(Y),Y.castShadow&&T.pushShadow(Y))}),S!==j&&S.traverseVisible(function(Y){Y.isLight&&Y.layers.test(O.layers)&&(T.pushLight(Y),Y.castShadow&&T.pushShadow(Y))}),T.setupLights(),H!==null&&H.updateLights(T.state.lightsArray),an=this.localClippingEnabled,Be=it.init(this.clippingPlanes,an),Be===!0&&it.setGlobalState(this.clippingPlanes,O),H!==null&&pt.render(T.state.shadowsArray,j,O);let $=new Set;return S.traverse(function(Y){if(!(Y.isMesh||Y.isPoints||Y.isLine||Y.isSprite))return;let Et=Y.material;if(Et)if(Array.isArray(Et))for(let Pt=0;Pt<Et.length;Pt++){let Tt=Et[Pt];Ao(Tt,j,O,Y),$.add(Tt)}else Ao(Et,j,O,Y),$.add(Et)}),T=E.pop(),H!==null&&H.renderEnd(),$},this.compileAsync=function(S,O,j=null){let $=this.compile(S,O,j);return new Promise(Y=>{function Et(){if($.forEach(function(Pt){let It=zt.get(Pt).currentProgram;(It===void 0||It.isReady())&&$.delete(Pt)}),$.size===0){Y(S);return}setTimeout(Et,10)}Zt.get("KHR_parallel_shader_compile")!==null?Et():setTimeout(Et,10)})};let Tr=null;function jh(S){Tr&&Tr(S)}function Ua(){ns.stop()}function Oi(){ns.start()}let ns=new Y0;ns.setAnimationLoop(jh),typeof self<"u"&&ns.setContext(self),this.setAnimationLoop=function(S){Tr=S,lt.setAnimationLoop(S),S===null?ns.stop():ns.start()},lt.addEventListener("sessionstart",Ua),lt.addEventListener("sessionend",Oi),this.render=function(S,O){if(O!==void 0&&O.isCamera!==!0){ne("WebGLRenderer.render: camera is not an instance of THREE.Camera.");return}if(L===!0)return;H!==null&&H.renderStart(S,O);let j=lt.enabled===!0&&lt.isPresenting===!0,$=V!==null&&(ct===null||j)&&V.begin(D,ct);if(S.matrixWorldAutoUpdate===!0&&S.updateMatrixWorld(),O.parent===null&&O.matrixWorldAutoUpdate===!0&&O.updateMatrixWorld(),lt.enabled===!0&&lt.isPresenting===!0&&(V===null||V.isCompositing()===!1)&&(lt.cameraAutoUpdate===!0&&lt.updateCamera(O),O=lt.getCamera()),S.isScene===!0&&S.onBeforeRender(D,S,O,ct),T=et.get(S,E.length),T.init(O),T.state.textureUnits=$t.getTextureUnits(),E.push(T),Le.multiplyMatrices(O.projectionMatrix,O.matrixWorldInverse),O.isArrayCamera?$e.setFromArrayCamera(O):se.setFromProjectionMatrix(Le,yi,O.reversedDepth),an=this.localClippingEnabled,Be=it.init(this.clippingPlanes,an),P=vt.get(S,_.length),P.init(),_.push(P),this.info.render.frame++,lt.enabled===!0&&lt.isPresenting===!0){let Pt=D.xr.getDepthSensingMesh();Pt!==null&&is(Pt,O,-1/0,D.sortObjects)}is(S,O,0,D.sortObjects),P.finish(),H!==null&&H.updateLights(T.state.lightsArray),D.sortObjects===!0&&P.sort(Wt,oe),je=lt.enabled===!1||lt.isPresenting===!1||lt.hasDepthSensing()===!1,je&&U.addToRenderList(P,S),this.info.autoReset===!0&&this.info.reset(),Be===!0&&it.beginShadows();let Y=T.state.shadowsArray;if(pt.render(Y,S,O),Be===!0&&it.endShadows(),($&&V.hasRenderPass())===!1){let Pt=P.opaque,Tt=P.transmissive;if(T.setupLights(),O.isArrayCamera){let It=O.cameras;if(Tt.length>0)for(let kt=0,ee=It.length;kt<ee;kt++){let pe=It[kt];Si(Pt,Tt,S,pe)}je&&U.render(S);for(let kt=0,ee=It.length;kt<ee;kt++){let pe=It[kt];Ro(P,S,pe,pe.viewport)}}else Tt.length>0&&Si(Pt,Tt,S,O),je&&U.render(S),Ro(P,S,O)}ct!==null&&k===0&&($t.updateMultisampleRenderTarget(ct),$t.updateRenderTargetMipmap(ct)),$&&V.end(D),S.isScene===!0&&S.onAfterRender(D,S,O),bt.resetDefaultState(),K=-1,Q=null,E.pop(),E.length>0?(T=E[E.length-1],$t.setTextureUnits(T.state.textureUnits),Be===!0&&it.setGlobalState(D.clippingPlanes,T.state.camera)):T=null,_.pop(),_.length>0?P=_[_.length-1]:P=null,H!==null&&H.renderEnd()};function is(S,O,j,$){if(S.visible===!1)return;if(S.layers.test(O.layers)){if(S.isGroup)j=S.renderOrder;else if(S.isLOD)S.autoUpdate===!0&&S.update(O);else if(S.isLight)T.pushLight(S),S.castShadow&&T.pushShadow(S);else if(S.isSprite){let Pt=O.isArrayCamera?$e:se;if(!S.frustumCulled||S.intersectsFrustum(Pt)){$&&be.setFromMatrixPosition(S.matrixWorld).applyMatrix4(Le);let Tt=ht.update(S),It=S.material;It.visible&&P.push(S,Tt,It,j,be.z,null,O)}}else if(S.isMesh||S.isLine||S.isPoints){let Pt=O.isArrayCamera?$e:se;if(!S.frustumCulled||S.intersectsFrustum(Pt)){let Tt=ht.update(S),It=S.material;if($&&(S.boundingSphere!==void 0?(S.boundingSphere===null&&S.computeBoundingSphere(),be.copy(S.boundingSphere.center)):(Tt.boundingSphere===null&&Tt.computeBoundingSphere(),be.copy(Tt.boundingSphere.center)),be.applyMatrix4(S.matrixWorld).applyMatrix4(Le)),Array.isArray(It)){let kt=Tt.groups;for(let ee=0,pe=kt.length;ee<pe;ee++){let Bt=kt[ee],me=It[Bt.materialIndex];me&&me.visible&&P.push(S,Tt,me,j,be.z,Bt,O)}}else It.visible&&P.push(S,Tt,It,j,be.z,null,O)}}}let Et=S.children;for(let Pt=0,Tt=Et.length;Pt<Tt;Pt++)is(Et[Pt],O,j,$)}function Ro(S,O,j,$){let{opaque:Y,transmissive:Et,transparent:Pt}=S;T.setupLightsView(j),Be===!0&&it.setGlobalState(D.clippingPlanes,j),$&&Mt.viewport(st.copy($)),Y.length>0&&Qe(Y,O,j),Et.length>0&&Qe(Et,O,j),Pt.length>0&&Qe(Pt,O,j),Mt.buffers.depth.setTest(!0),Mt.buffers.depth.setMask(!0),Mt.buffers.color.setMask(!0),Mt.setPolygonOffset(!1)}function Si(S,O,j,$){if((j.isScene===!0?j.overrideMaterial:null)!==null)return;if(T.state.transmissionRenderTarget[$.id]===void 0){let Bt=Zt.has("EXT_color_buffer_half_float")||Zt.has("EXT_color_buffer_float");T.state.transmissionRenderTarget[$.id]=new ci(1,1,{generateMipmaps:!0,type:Bt?Di:fi,minFilter:xs,samples:Math.max(4,ae.samples),stencilBuffer:r,resolveDepthBuffer:!1,resolveStencilBuffer:!1,storeMultisampledDepthBuffer:!1,storeMultisampledStencilBuffer:!1,colorSpace:ge.workingColorSpace})}let Et=T.state.transmissionRenderTarget[$.id],Pt=$.viewport||st;Et.setSize(Pt.z*D.transmissionResolutionScale,Pt.w*D.transmissionResolutionScale);let Tt=D.getRenderTarget(),It=D.getActiveCubeFace(),kt=D.getActiveMipmapLevel();D.setRenderTarget(Et),D.getClearColor(tt),mt=D.getClearAlpha(),mt<1&&D.setClearColor(16777215,.5),D.clear(),je&&U.render(j);let ee=D.toneMapping;D.toneMapping=ji;let pe=$.viewport;if($.viewport!==void 0&&($.viewport=void 0),T.setupLightsView($),Be===!0&&it.setGlobalState(D.clippingPlanes,$),Qe(S,j,$),$t.updateMultisampleRenderTarget(Et),$t.updateRenderTargetMipmap(Et),Zt.has("WEBGL_multisampled_render_to_texture")===!1){let Bt=!1;for(let me=0,Je=O.length;me<Je;me++){let Ce=O[me],{object:Pe,geometry:xn,material:Ut,group:cn}=Ce;if(Ut.side===On&&Pe.layers.test($.layers)){let _e=Ut.side;Ut.side=Kn,Ut.needsUpdate=!0,sn(Pe,j,$,xn,Ut,cn),Ut.side=_e,Ut.needsUpdate=!0,Bt=!0}}Bt===!0&&($t.updateMultisampleRenderTarget(Et),$t.updateRenderTargetMipmap(Et))}D.setRenderTarget(Tt,It,kt),D.setClearColor(tt,mt),pe!==void 0&&($.viewport=pe),D.toneMapping=ee}function Qe(S,O,j){let $=O.isScene===!0?O.overrideMaterial:null;for(let Y=0,Et=S.length;Y<Et;Y++){let Pt=S[Y],{object:Tt,geometry:It,group:kt}=Pt,ee=Pt.material;ee.allowOverride===!0&&$!==null&&(ee=$),Tt.layers.test(j.layers)&&sn(Tt,O,j,It,ee,kt)}}function sn(S,O,j,$,Y,Et){H!==null&&Y.isNodeMaterial&&H.setObject(S,Y),S.onBeforeRender(D,O,j,$,Y,Et),S.modelViewMatrix.multiplyMatrices(j.matrixWorldInverse,S.matrixWorld),S.normalMatrix.getNormalMatrix(S.modelViewMatrix),Y.onBeforeRender(D,O,j,$,S,Et),Y.transparent===!0&&Y.side===On&&Y.forceSinglePass===!1?(Y.side=Kn,Y.needsUpdate=!0,D.renderBufferDirect(j,O,$,Y,S,Et),Y.side=$s,Y.needsUpdate=!0,D.renderBufferDirect(j,O,$,Y,S,Et),Y.side=On):D.renderBufferDirect(j,O,$,Y,S,Et),S.onAfterRender(D,O,j,$,Y,Et)}function rn(S){let O=0;for(let j of S)j.texture!==null&&O++;return O}function Bi(S,O,j){O.isScene!==!0&&(O=gn);let $=zt.get(S),Y=T.state.lights,Et=T.state.shadowsArray,Pt=Y.state.version,Tt=ot.getParameters(S,Y.state,Et,O,j,T.state.lightProbeGridArray),It=ot.getProgramCacheKey(Tt),kt=$.programs;$.environment=S.isMeshStandardMaterial||S.isMeshLambertMaterial||S.isMeshPhongMaterial?O.environment:null,$.fog=O.fog;let ee=S.isMeshStandardMaterial||S.isMeshLambertMaterial&&!S.envMap||S.isMeshPhongMaterial&&!S.envMap;$.envMap=R.get(S.envMap||$.environment,ee),$.envMapRotation=$.environment!==null&&S.envMap===null?O.environmentRotation:S.envMapRotation,kt===void 0&&(S.addEventListener("dispose",ce),kt=new Map,$.programs=kt,$.programVariants=new Map);let pe=kt.get(It);if(pe!==void 0){if($.currentProgram===pe&&$.lightsStateVersion===Pt)return Co(S,Tt),pe}else Tt.uniforms=ot.getUniforms(S),H!==null&&S.isNodeMaterial&&H.build(S,j,Tt),S.onBeforeCompile(Tt,D),pe=ot.acquireProgram(Tt,It),kt.set(It,pe),$.uniforms=Tt.uniforms;let Bt=$.uniforms;return(!S.isShaderMaterial&&!S.isRawShaderMaterial||S.clipping===!0)&&(Bt.clippingPlanes=it.uniform),Co(S,Tt),$.needsLights=Ms(S),$.lightsStateVersion=Pt,$.needsLights&&(Bt.ambientLightColor.value=Y.state.ambient,Bt.lightProbe.value=Y.state.probe,Bt.sunLights.value=Y.state.sun,Bt.sunLightShadows.value=Y.state.sunShadow,Bt.directionalLights.value=Y.state.directional,Bt.directionalLightShadows.value=Y.state.directionalShadow,Bt.spotLights.value=Y.state.spot,Bt.spotLightShadows.value=Y.state.spotShadow,Bt.rectAreaLights.value=Y.state.rectArea,Bt.ltc_1.value=Y.state.rectAreaLTC1,Bt.ltc_2.value=Y.state.rectAreaLTC2,Bt.pointLights.value=Y.state.point,Bt.pointLightShadows.value=Y.state.pointShadow,Bt.hemisphereLights.value=Y.state.hemi,Bt.sunShadowMatrix.value=Y.state.sunShadowMatrix,Bt.sunShadowCascade.value=Y.state.sunShadowCascade,Bt.directionalShadowMatrix.value=Y.state.directionalShadowMatrix,Bt.spotLightMatrix.value=Y.state.spotLightMatrix,Bt.spotLightMap.value=Y.state.spotLightMap,Bt.pointShadowMatrix.value=Y.state.pointShadowMatrix),$.numLightProbeGrids=rn(T.state.lightProbeGridArray),$.currentProgram=pe,$.uniformsList=null,pe}function Qn(S,O,j,$,Y){let Et=zt.get(S),Pt=Et.currentProgram.id+","+$+","+Y,Tt=Et.programVariants.get(Pt);return Tt===void 0?(Tt=Bi(S,O,j),Et.programVariants.set(Pt,Tt)):(Et.currentProgram=Tt,Et.uniformsList=null,Et.outputColorSpace=$,Et.toneMapping=Y),Tt}function Ss(S){if(S.uniformsList===null){let O=S.currentProgram.getUniforms();S.uniformsList=Mo.seqWithValue(O.seq,S.uniforms)}return S.uniformsList}function Co(S,O){let j=zt.get(S);j.outputColorSpace=O.outputColorSpace,j.batching=O.batching,j.batchingColor=O.batchingColor,j.instancing=O.instancing,j.instancingColor=O.instancingColor,j.instancingMorph=O.instancingMorph,j.skinning=O.skinning,j.morphTargets=O.morphTargets,j.morphNormals=O.morphNormals,j.morphColors=O.morphColors,j.morphTargetsCount=O.morphTargetsCount,j.numClippingPlanes=O.numClippingPlanes,j.numIntersection=O.numClipIntersection,j.vertexAlphas=O.vertexAlphas,j.vertexTangents=O.vertexTangents,j.toneMapping=O.toneMapping}function Po(S,O,j,$,Y){O.isScene!==!0&&(O=gn),$t.resetTextureUnits();let Et=O.fog,Pt=$.isMeshStandardMaterial||$.isMeshLambertMaterial||$.isMeshPhongMaterial?O.environment:null,Tt=ct===null?D.outputColorSpace:ct.isXRRenderTarget===!0?ct.texture.colorSpace:ge.workingColorSpace,It=$.isMeshStandardMaterial||$.isMeshLambertMaterial&&!$.envMap||$.isMeshPhongMaterial&&!$.envMap,kt=R.get($.envMap||Pt,It),ee=$.vertexColors===!0&&!!j.attributes.color&&j.attributes.color.itemSize===4,pe=!!j.attributes.tangent&&(!!$.normalMap||$.anisotropy>0),Bt=!!j.morphAttributes.position,me=!!j.morphAttributes.normal,Je=!!j.morphAttributes.color,Ce=ji;$.toneMapped&&(ct===null||ct.isXRRenderTarget===!0)&&(Ce=D.toneMapping);let Pe=j.morphAttributes.position||j.morphAttributes.normal||j.morphAttributes.color,xn=Pe!==void 0?Pe.length:0,Ut=zt.get($),cn=T.state.lights;if(Be===!0&&(an===!0||S!==Q)){let Ie=S===Q&&$.id===K;it.setState($,S,Ie)}let _e=!1,ss=!1;$.version===Ut.__version?Ut.needsLights&&Ut.lightsStateVersion!==cn.state.version||Y.isBatchedMesh&&Ut.batching===!1||!Y.isBatchedMesh&&Ut.batching===!0||Y.isBatchedMesh&&Ut.batchingColor===!0&&Y._colorsTexture===null||Y.isBatchedMesh&&Ut.batchingColor===!1&&Y._colorsTexture!==null||Y.isInstancedMesh&&Ut.instancing===!1||!Y.isInstancedMesh&&Ut.instancing===!0||Y.isSkinnedMesh&&Ut.skinning===!1||!Y.isSkinnedMesh&&Ut.skinning===!0||Y.isInstancedMesh&&Ut.instancingColor===!0&&Y.instanceColor===null||Y.isInstancedMesh&&Ut.instancingColor===!1&&Y.instanceColor!==null||Y.isInstancedMesh&&Ut.instancingMorph===!0&&Y.morphTexture===null||Y.isInstancedMesh&&Ut.instancingMorph===!1&&Y.morphTexture!==null||Ut.envMap!==kt||$.fog===!0&&Ut.fog!==Et||Ut.numClippingPlanes!==void 0&&(Ut.numClippingPlanes!==it.numPlanes||Ut.numIntersection!==it.numIntersection)||Ut.vertexAlphas!==ee||Ut.vertexTangents!==pe||Ut.morphTargets!==Bt||Ut.morphNormals!==me||Ut.morphColors!==Je||Ut.morphTargetsCount!==xn||Ut.numLightProbeGrids!==rn(T.state.lightProbeGridArray)?_e=!0:(Ut.outputColorSpace!==Tt||Ut.toneMapping!==Ce)&&(ss=!0):(_e=!0,Ut.__version=$.version);let hn=Ut.currentProgram;(_e===!0||ss===!0)&&(hn=ss===!0?Qn($,O,Y,Tt,Ce):Bi($,O,Y),H&&$.isNodeMaterial&&H.onUpdateProgram($,hn,Ut));let Cr=!1,ki=!1,rs=!1,ue=hn.getUniforms(),tn=Ut.uniforms;if(Mt.useProgram(hn.program)&&(Cr=!0,ki=!0,rs=!0),$.id!==K&&(K=$.id,ki=!0),Cr||Q!==S){Mt.buffers.depth.getReversed()&&S.reversedDepth!==!0&&(S._reversedDepth=!0,S.updateProjectionMatrix()),ue.setValue(F,"projectionMatrix",S.projectionMatrix),ue.setValue(F,"viewMatrix",S.matrixWorldInverse);let un=ue.map.cameraPosition;un!==void 0&&un.setValue(F,Sn.setFromMatrixPosition(S.matrixWorld)),ae.logarithmicDepthBuffer&&ue.setValue(F,"logDepthBufFC",2/(Math.log(S.far+1)/Math.LN2)),($.isMeshPhongMaterial||$.isMeshToonMaterial||$.isMeshLambertMaterial||$.isMeshBasicMaterial||$.isMeshStandardMaterial||$.isShaderMaterial)&&ue.setValue(F,"isOrthographic",S.isOrthographicCamera===!0),Q!==S&&(Q=S,ki=!0,rs=!0)}if(Ut.needsLights&&(cn.state.sunShadowMap.length>0&&ue.setValue(F,"sunShadowMap",cn.state.sunShadowMap,$t),cn.state.directionalShadowMap.length>0&&ue.setValue(F,"directionalShadowMap",cn.state.directionalShadowMap,$t),cn.state.spotShadowMap.length>0&&ue.setValue(F,"spotShadowMap",cn.state.spotShadowMap,$t),cn.state.pointShadowMap.length>0&&ue.setValue(F,"pointShadowMap",cn.state.pointShadowMap,$t)),Y.isSkinnedMesh){ue.setOptional(F,Y,"bindMatrix"),ue.setOptional(F,Y,"bindMatrixInverse");let Ie=Y.skeleton;Ie&&(Ie.boneTexture===null&&Ie.computeBoneTexture(),ue.setValue(F,"boneTexture",Ie.boneTexture,$t))}Y.isBatchedMesh&&(ue.setOptional(F,Y,"batchingTexture"),ue.setValue(F,"batchingTexture",Y._matricesTexture,$t),ue.setOptional(F,Y,"batchingIdTexture"),ue.setValue(F,"batchingIdTexture",Y._indirectTexture,$t),ue.setOptional(F,Y,"batchingColorTexture"),Y._colorsTexture!==null&&ue.setValue(F,"batchingColorTexture",Y._colorsTexture,$t));let zn=j.morphAttributes;if((zn.position!==void 0||zn.normal!==void 0||zn.color!==void 0)&&rt.update(Y,j,hn),(ki||Ut.receiveShadow!==Y.receiveShadow)&&(Ut.receiveShadow=Y.receiveShadow,ue.setValue(F,"receiveShadow",Y.receiveShadow)),($.isMeshStandardMaterial||$.isMeshLambertMaterial||$.isMeshPhongMaterial)&&$.envMap===null&&O.environment!==null&&(tn.envMapIntensity.value=O.environmentIntensity),tn.dfgLUT!==void 0&&(tn.dfgLUT.value=ZE()),ki){if(ue.setValue(F,"toneMappingExposure",D.toneMappingExposure),Ut.needsLights&&Ar(tn,rs),Et&&$.fog===!0&&xt.refreshFogUniforms(tn,Et),xt.refreshMaterialUniforms(tn,$,St,At,T.state.transmissionRenderTarget[S.id]),Ut.needsLights&&Ut.numLightProbeGrids>0){let Ie=w,un=0;for(let Nn of T.state.lightProbeGridArray)Nn.texture!==null&&(Ie.textures[un]=Nn.texture,Ie.min[un]=Nn.boundingBox.min,Ie.max[un]=Nn.boundingBox.max,Ie.resolution[un]=Nn.resolution,un++);for(let Nn in Ie)Ie[Nn].length=un;tn.probesSH.value=Ie.textures,tn.probesMin.value=Ie.min,tn.probesMax.value=Ie.max,tn.probesResolution.value=Ie.resolution}Mo.upload(F,Ss(Ut),tn,$t)}if($.isShaderMaterial&&$.uniformsNeedUpdate===!0&&(Mo.upload(F,Ss(Ut),tn,$t),$.uniformsNeedUpdate=!1),$.isSpriteMaterial&&ue.setValue(F,"center",Y.center),ue.setValue(F,"modelViewMatrix",Y.modelViewMatrix),ue.setValue(F,"normalMatrix",Y.normalMatrix),ue.setValue(F,"modelMatrix",Y.matrixWorld),$.uniformsGroups!==void 0){let Ie=$.uniformsGroups;for(let un=0,Nn=Ie.length;un<Nn;un++){let Fa=Ie[un];Ht.update(Fa,hn),Ht.bind(Fa,hn)}}return hn}function Ar(S,O){S.ambientLightColor.needsUpdate=O,S.lightProbe.needsUpdate=O,S.sunLights.needsUpdate=O,S.sunLightShadows.needsUpdate=O,S.directionalLights.needsUpdate=O,S.directionalLightShadows.needsUpdate=O,S.pointLights.needsUpdate=O,S.pointLightShadows.needsUpdate=O,S.spotLights.needsUpdate=O,S.spotLightShadows.needsUpdate=O,S.rectAreaLights.needsUpdate=O,S.hemisphereLights.needsUpdate=O}function Ms(S){return S.isMeshLambertMaterial||S.isMeshToonMaterial||S.isMeshPhongMaterial||S.isMeshStandardMaterial||S.isShadowMaterial||S.isShaderMaterial&&S.lights===!0}this.getActiveCubeFace=function(){return J},this.getActiveMipmapLevel=function(){return k},this.getRenderTarget=function(){return ct},this.setRenderTargetTextures=function(S,O,j){let $=zt.get(S);$.__autoAllocateDepthBuffer=S.resolveDepthBuffer===!1,$.__autoAllocateDepthBuffer===!1&&($.__useRenderToTexture=!1),zt.get(S.texture).__webglTexture=O,zt.get(S.depthTexture).__webglTexture=$.__autoAllocateDepthBuffer?void 0:j,$.__hasExternalTextures=!0},this.setRenderTargetFramebuffer=function(S,O){let j=zt.get(S);j.__webglFramebuffer=O,j.__useDefaultFramebuffer=O===void 0},this.setRenderTarget=function(S,O=0,j=0){ct=S,J=O,k=j;let $=null,Y=!1,Et=!1;if(S){let Tt=zt.get(S);if(Tt.__useDefaultFramebuffer!==void 0){Mt.bindFramebuffer(F.FRAMEBUFFER,Tt.__webglFramebuffer),st.copy(S.viewport),ft.copy(S.scissor),ut=S.scissorTest,Mt.viewport(st),Mt.scissor(ft),Mt.setScissorTest(ut),K=-1;return}else if(Tt.__webglFramebuffer===void 0)$t.setupRenderTarget(S);else if(Tt.__hasExternalTextures)$t.rebindTextures(S,zt.get(S.texture).__webglTexture,zt.get(S.depthTexture).__webglTexture);else if(S.depthBuffer){let ee=S.depthTexture;if(Tt.__boundDepthTexture!==ee){if(ee!==null&&zt.has(ee)&&(S.width!==ee.image.width||S.height!==ee.image.height))throw new Error("THREE.WebGLRenderer: Attached DepthTexture is initialized to the incorrect size.");$t.setupDepthRenderbuffer(S)}}let It=S.texture;(It.isData3DTexture||It.isDataArrayTexture||It.isCompressedArrayTexture)&&(Et=!0);let kt=zt.get(S).__webglFramebuffer;S.isWebGLCubeRenderTarget?(Array.isArray(kt[O])?$=kt[O][j]:$=kt[O],Y=!0):S.samples>0&&$t.useMultisampledRTT(S)===!1?$=zt.get(S).__webglMultisampledFramebuffer:Array.isArray(kt)?$=kt[j]:$=kt,st.copy(S.viewport),ft.copy(S.scissor),ut=S.scissorTest}else st.copy(Vt).multiplyScalar(St).floor(),ft.copy(de).multiplyScalar(St).floor(),ut=he;if(j!==0&&($=G),Mt.bindFramebuffer(F.FRAMEBUFFER,$)&&Mt.drawBuffers(S,$),Mt.viewport(st),Mt.scissor(ft),Mt.setScissorTest(ut),Y){let Tt=zt.get(S.texture);F.framebufferTexture2D(F.FRAMEBUFFER,F.COLOR_ATTACHMENT0,F.TEXTURE_CUBE_MAP_POSITIVE_X+O,Tt.__webglTexture,j)}else if(Et){let Tt=O;for(let It=0;It<S.textures.length;It++){let kt=zt.get(S.textures[It]);F.framebufferTextureLayer(F.FRAMEBUFFER,F.COLOR_ATTACHMENT0+It,kt.__webglTexture,j,Tt)}}else if(S!==null&&j!==0){let Tt=zt.get(S.texture);F.framebufferTexture2D(F.FRAMEBUFFER,F.COLOR_ATTACHMENT0,F.TEXTURE_2D,Tt.__webglTexture,j)}K=-1};function Rr(S){let O=zt.get(S);return(O.__readFormat!==S.format||O.__readType!==S.type)&&(O.__readFormat=S.format,O.__readType=S.type,O.__formatReadable=ae.textureFormatReadable(S.format),O.__typeReadable=ae.textureTypeReadable(S.type)),O}this.readRenderTargetPixels=function(S,O,j,$,Y,Et,Pt,Tt=0){if(!(S&&S.isWebGLRenderTarget)){ne("WebGLRenderer.readRenderTargetPixels: renderTarget is not THREE.WebGLRenderTarget.");return}let It=zt.get(S).__webglFramebuffer;if(S.isWebGLCubeRenderTarget&&Pt!==void 0&&(It=It[Pt],Array.isArray(It)&&(It=It[0])),It){Mt.bindFramebuffer(F.FRAMEBUFFER,It);try{let kt=S.textures[Tt],ee=kt.format,pe=kt.type;S.textures.length>1&&F.readBuffer(F.COLOR_ATTACHMENT0+Tt);let Bt=Rr(kt);if(Bt.__formatReadable===!1){ne("WebGLRenderer.readRenderTargetPixels: renderTarget is not in RGBA or implementation defined format.");return}if(Bt.__typeReadable===!1){ne("WebGLRenderer.readRenderTargetPixels: renderTarget is not in UnsignedByteType or implementation defined type.");return}O>=0&&O<=S.width-$&&j>=0&&j<=S.height-Y&&F.readPixels(O,j,$,Y,gt.convert(ee),gt.convert(pe),Et)}finally{let kt=ct!==null?zt.get(ct).__webglFramebuffer:null;Mt.bindFramebuffer(F.FRAMEBUFFER,kt)}}},this.readRenderTargetPixelsAsync=async function(S,O,j,$,Y,Et,Pt,Tt=0){if(!(S&&S.isWebGLRenderTarget))throw new Error("THREE.WebGLRenderer.readRenderTargetPixels: renderTarget is not THREE.WebGLRenderTarget.");let It=zt.get(S).__webglFramebuffer;if(S.isWebGLCubeRenderTarget&&Pt!==void 0&&(It=It[Pt],Array.isArray(It)&&(It=It[0])),It)if(O>=0&&O<=S.width-$&&j>=0&&j<=S.height-Y){Mt.bindFramebuffer(F.FRAMEBUFFER,It);let kt=S.textures[Tt],ee=kt.format,pe=kt.type;S.textures.length>1&&F.readBuffer(F.COLOR_ATTACHMENT0+Tt);let Bt=Rr(kt);if(Bt.__formatReadable===!1)throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: renderTarget is not in RGBA or implementation defined format.");if(Bt.__typeReadable===!1)throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: renderTarget is not in UnsignedByteType or implementation defined type.");let me=F.createBuffer();F.bindBuffer(F.PIXEL_PACK_BUFFER,me),F.bufferData(F.PIXEL_PACK_BUFFER,Et.byteLength,F.STREAM_READ),F.readPixels(O,j,$,Y,gt.convert(ee),gt.convert(pe),0),F.bindBuffer(F.PIXEL_PACK_BUFFER,null);let Je=ct!==null?zt.get(ct).__webglFramebuffer:null;Mt.bindFramebuffer(F.FRAMEBUFFER,Je);let Ce=F.fenceSync(F.SYNC_GPU_COMMANDS_COMPLETE,0);return F.flush(),await _0(F,Ce,4),F.bindBuffer(F.PIXEL_PACK_BUFFER,me),F.getBufferSubData(F.PIXEL_PACK_BUFFER,0,Et),F.bindBuffer(F.PIXEL_PACK_BUFFER,null),F.deleteBuffer(me),F.deleteSync(Ce),Et}else throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: requested read bounds are out of range.")},this.copyFramebufferToTexture=function(S,O=null,j=0){let $=Math.pow(2,-j),Y=Math.floor(S.image.width*$),Et=Math.floor(S.image.height*$),Pt=O!==null?O.x:0,Tt=O!==null?O.y:0;$t.setTexture2D(S,0),F.copyTexSubImage2D(F.TEXTURE_2D,j,0,0,Pt,Tt,Y,Et),Mt.unbindTexture()},this.copyTextureToTexture=function(S,O,j=null,$=null,Y=0,Et=0){let Pt,Tt,It,kt,ee,pe,Bt,me,Je,Ce=S.isCompressedTexture?S.mipmaps[Et]:S.image;if(j!==null)Pt=j.max.x-j.min.x,Tt=j.max.y-j.min.y,It=j.isBox3?j.max.z-j.min.z:1,kt=j.min.x,ee=j.min.y,pe=j.isBox3?j.min.z:0;else{let ue=Math.pow(2,-Y);Pt=Math.floor(Ce.width*ue),Tt=Math.floor(Ce.height*ue),S.isDataArrayTexture?It=Ce.depth:S.isData3DTexture?It=Math.floor(Ce.depth*ue):It=1,kt=0,ee=0,pe=0}$!==null?(Bt=$.x,me=$.y,Je=$.z):(Bt=0,me=0,Je=0);let Pe=gt.convert(O.format),xn=gt.convert(O.type),Ut;O.isData3DTexture?($t.setTexture3D(O,0),Ut=F.TEXTURE_3D):O.isDataArrayTexture||O.isCompressedArrayTexture?($t.setTexture2DArray(O,0),Ut=F.TEXTURE_2D_ARRAY):($t.setTexture2D(O,0),Ut=F.TEXTURE_2D),Mt.activeTexture(F.TEXTURE0),Mt.pixelStorei(F.UNPACK_FLIP_Y_WEBGL,O.flipY),Mt.pixelStorei(F.UNPACK_PREMULTIPLY_ALPHA_WEBGL,O.premultiplyAlpha),Mt.pixelStorei(F.UNPACK_ALIGNMENT,O.unpackAlignment);let cn=Mt.getParameter(F.UNPACK_ROW_LENGTH),_e=Mt.getParameter(F.UNPACK_IMAGE_HEIGHT),ss=Mt.getParameter(F.UNPACK_SKIP_PIXELS),hn=Mt.getParameter(F.UNPACK_SKIP_ROWS),Cr=Mt.getParameter(F.UNPACK_SKIP_IMAGES);Mt.pixelStorei(F.UNPACK_ROW_LENGTH,Ce.width),Mt.pixelStorei(F.UNPACK_IMAGE_HEIGHT,Ce.height),Mt.pixelStorei(F.UNPACK_SKIP_PIXELS,kt),Mt.pixelStorei(F.UNPACK_SKIP_ROWS,ee),Mt.pixelStorei(F.UNPACK_SKIP_IMAGES,pe);let ki=S.isDataArrayTexture||S.isData3DTexture,rs=O.isDataArrayTexture||O.isData3DTexture;if(S.isDepthTexture){let ue=zt.get(S),tn=zt.get(O),zn=zt.get(ue.__renderTarget),Ie=zt.get(tn.__renderTarget);Mt.bindFramebuffer(F.READ_FRAMEBUFFER,zn.__webglFramebuffer),Mt.bindFramebuffer(F.DRAW_FRAMEBUFFER,Ie.__webglFramebuffer);for(let un=0;un<It;un++)ki&&(F.framebufferTextureLayer(F.READ_FRAMEBUFFER,F.COLOR_ATTACHMENT0,zt.get(S).__webglTexture,Y,pe+un),F.framebufferTextureLayer(F.DRAW_FRAMEBUFFER,F.COLOR_ATTACHMENT0,zt.get(O).__webglTexture,Et,Je+un)),F.blitFramebuffer(kt,ee,kt+Pt,ee+Tt,Bt,me,Bt+Pt,me+Tt,F.DEPTH_BUFFER_BIT,F.NEAREST);Mt.bindFramebuffer(F.READ_FRAMEBUFFER,null),Mt.bindFramebuffer(F.DRAW_FRAMEBUFFER,null)}else if(Y!==0||S.isRenderTargetTexture||zt.has(S)){let ue=zt.get(S),tn=zt.get(O);Mt.bindFramebuffer(F.READ_FRAMEBUFFER,N),Mt.bindFramebuffer(F.DRAW_FRAMEBUFFER,z);for(let zn=0;zn<It;zn++)ki?F.framebufferTextureLayer(F.READ_FRAMEBUFFER,F.COLOR_ATTACHMENT0,ue.__webglTexture,Y,pe+zn):F.framebufferTexture2D(F.READ_FRAMEBUFFER,F.COLOR_ATTACHMENT0,F.TEXTURE_2D,ue.__webglTexture,Y),rs?F.framebufferTextureLayer(F.DRAW_FRAMEBUFFER,F.COLOR_ATTACHMENT0,tn.__webglTexture,Et,Je+zn):F.framebufferTexture2D(F.DRAW_FRAMEBUFFER,F.COLOR_ATTACHMENT0,F.TEXTURE_2D,tn.__webglTexture,Et),Y!==0?F.blitFramebuffer(kt,ee,kt+Pt,ee+Tt,Bt,me,Bt+Pt,me+Tt,F.COLOR_BUFFER_BIT,F.NEAREST):rs?F.copyTexSubImage3D(Ut,Et,Bt,me,Je+zn,kt,ee,Pt,Tt):F.copyTexSubImage2D(Ut,Et,Bt,me,kt,ee,Pt,Tt);Mt.bindFramebuffer(F.READ_FRAMEBUFFER,null),Mt.bindFramebuffer(F.DRAW_FRAMEBUFFER,null)}else rs?S.isDataTexture||S.isData3DTexture?F.texSubImage3D(Ut,Et,Bt,me,Je,Pt,Tt,It,Pe,xn,Ce.data):O.isCompressedArrayTexture?F.compressedTexSubImage3D(Ut,Et,Bt,me,Je,Pt,Tt,It,Pe,Ce.data):F.texSubImage3D(Ut,Et,Bt,me,Je,Pt,Tt,It,Pe,xn,Ce):S.isDataTexture?F.texSubImage2D(F.TEXTURE_2D,Et,Bt,me,Pt,Tt,Pe,xn,Ce.data):S.isCompressedTexture?F.compressedTexSubImage2D(F.TEXTURE_2D,Et,Bt,me,Ce.width,Ce.height,Pe,Ce.data):F.texSubImage2D(F.TEXTURE_2D,Et,Bt,me,Pt,Tt,Pe,xn,Ce);Mt.pixelStorei(F.UNPACK_ROW_LENGTH,cn),Mt.pixelStorei(F.UNPACK_IMAGE_HEIGHT,_e),Mt.pixelStorei(F.UNPACK_SKIP_PIXELS,ss),Mt.pixelStorei(F.UNPACK_SKIP_ROWS,hn),Mt.pixelStorei(F.UNPACK_SKIP_IMAGES,Cr),Et===0&&O.generateMipmaps===!0&&O.mipmapsAutoUpdate===!0&&F.generateMipmap(Ut),Mt.unbindTexture()},this.initRenderTarget=function(S){zt.get(S).__webglFramebuffer===void 0&&$t.setupRenderTarget(S)},this.initTexture=function(S){S.isCubeTexture?$t.setTextureCube(S,0):S.isData3DTexture?$t.setTexture3D(S,0):S.isDataArrayTexture||S.isCompressedArrayTexture?$t.setTexture2DArray(S,0):$t.setTexture2D(S,0),Mt.unbindTexture()},this.resetState=function(){J=0,k=0,ct=null,Mt.reset(),bt.reset()},typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("observe",{detail:this}))}get coordinateSystem(){return yi}get outputColorSpace(){return this._outputColorSpace}set outputColorSpace(t){this._outputColorSpace=t;let e=this.getContext();e.drawingBufferColorSpace=ge._getDrawingBufferColorSpace(t),e.unpackColorSpace=ge._getUnpackColorSpace()}};var rx=26,ox=[.42,.78],JE=Math.PI-.02,KE=480,jE=38,QE=.15,tT=8,wh=class{constructor(){this.camera=new $n(rx,1,.001,10),this.target=new q,this.axis=new q(0,0,1),this.ahead=new q(0,1,0),this.aside=new q(1,0,0),this.upright=!1,this.homeDistance=1,this.margins={left:.03,right:.03,top:.03,bottom:.055},this.points=[],this.moved=!1,this.width=1,this.height=1,this.yaw=0,this.tilt=ox[0],this.distance=1}setSubject(t,e){this.points=t;let n=e.length()<.35,s=e.clone().normalize();if(this.upright=n&&Math.abs(s.z)<.9,this.upright)this.axis.set(0,0,1),this.ahead.copy(s).projectOnPlane(this.axis).normalize().negate();else{this.axis.copy(s.lengthSq()>0?s:new q(0,0,1));let r=Math.abs(this.axis.z)>.8?[0,1,0]:[0,0,1];this.ahead.set(...r).projectOnPlane(this.axis).normalize()}this.aside.crossVectors(this.ahead,this.axis),this.moved||this.home()}resize(t,e){this.width=t,this.height=e,this.camera.aspect=t/e,this.camera.updateProjectionMatrix(),this.moved?this.apply():this.home()}home(){this.moved=!1,this.yaw=0,this.tilt=this.upright?1.15:vd(.3+.27*this.width/this.height,...ox),this.points.length>0&&this.#t(),this.homeDistance=this.distance,this.apply()}orbit(t,e){this.moved=!0,this.yaw-=t,this.tilt=vd(this.tilt-e,0,JE),this.apply()}zoom(t){this.moved=!0;let{homeDistance:e}=this;this.distance=vd(this.distance/t,QE*e,tT*e),this.apply()}pan(t,e){this.moved=!0;let n=this.pixel(this.distance),{elements:s}=this.camera.matrixWorld;for(let[r,o]of[[0,-t],[4,e]])this.target.x+=s[r]*o*n,this.target.y+=s[r+1]*o*n,this.target.z+=s[r+2]*o*n;this.apply()}out(){return this.camera.position.clone().sub(this.target).normalize()}get zUp(){return this.axis.z>.9}at(t,e){let{camera:n,target:s}=this,r=s.clone().project(n).z;return new q(2*t/this.width-1,1-2*e/this.height,r).unproject(n)}pixel(t){return 2*t*Math.tan(rx*Math.PI/360)/this.height}apply(){let{camera:t,target:e,axis:n,tilt:s,yaw:r,distance:o}=this,a=new q().addScaledVector(this.ahead,-Math.cos(r)).addScaledVector(this.aside,Math.sin(r));t.up.set(0,0,0),t.up.addScaledVector(n,Math.sin(s)).addScaledVector(a,-Math.cos(s)),t.position.copy(e).addScaledVector(n,Math.cos(s)*o).addScaledVector(a,Math.sin(s)*o),t.near=o/50,t.far=o*10,t.lookAt(e),t.updateMatrixWorld(),t.updateProjectionMatrix()}#t(){let{points:t}=this,e=this.width<KE?jE/this.height:0,n={...this.margins,bottom:Math.max(this.margins.bottom,e)},s=new Ki().setFromPoints(t);s.getCenter(this.target),this.distance=2.5*s.getSize(new q).length();let r=new q,o=2-2*(n.left+n.right),a=2-2*(n.top+n.bottom);for(let l=0;l<12;l+=1){this.apply();let c=new ga;for(let g of t)r.copy(g).project(this.camera),c.expandByPoint(r);let h=c.getSize(new Jt),f=c.getCenter(new Jt),u=(f.x-(n.left-n.right))*this.width/2,d=(f.y-(n.bottom-n.top))*this.height/2;this.pan(-u,d),this.distance*=Math.max(h.x/o,h.y/a)}this.moved=!1,this.apply()}};function vd(i,t,e){return Math.max(t,Math.min(i,e))}function hx(i,t,e,n=80){let s=Math.floor(Math.sqrt(36e3/(e*i*t))),r=Math.ceil(n/Math.max(i,t));return Math.max(1,Math.min(s,r,8))}function ux(i,t,e,n=3){let s=new Uint32Array(i*t).map((o,a)=>a),r=Uint8Array.from(e);for(let o=0;o<n;o+=1){let a=Uint8Array.from(r);for(let l=0;l<s.length;l+=1){if(r[l])continue;let c=nT(i,t,r,l);c<0||(s[l]=s[c],a[l]=1)}r=a}return s}var eT=[[0,1],[0,-1],[1,0],[-1,0],[1,1],[1,-1],[-1,1],[-1,-1]];function nT(i,t,e,n){let s=Math.floor(n/t),r=n%t;for(let[o,a]of eT){let l=s+o,c=r+a;if(!(l<0||c<0||l>=i||c>=t)&&e[l*t+c])return l*t+c}return-1}function ax(i,t){let e=(i-1)*t+1,n=new Int32Array(e),s=new Float32Array(4*e);for(let r=0;r<e;r+=1){let o=Math.min(Math.floor(r/t),Math.max(0,i-2)),a=r/t-o;n[r]=o,s[4*r]=.5*a*(-1+a*(2-a)),s[4*r+1]=.5*(2+a*a*(-5+3*a)),s[4*r+2]=.5*a*(1+a*(4-3*a)),s[4*r+3]=.5*a*a*(a-1)}return{count:e,first:n,weights:s}}var Eh=class{constructor(t,e,n){this.rows=t,this.columns=e,this.factor=n,this.down=ax(t,n),this.right=ax(e,n),this.fineRows=this.down.count,this.fineColumns=this.right.count,this.count=this.fineRows*this.fineColumns,this.nodes=new Float32Array(t*e),this.between=new Float32Array(t*this.fineColumns)}apply(t,e,n,{stride:s=1,offset:r=0,bounded:o=!0}={}){let{nodes:a}=this;for(let l=0;l<a.length;l+=1)a[l]=t[(e?e[l]:l)*s+r];return this.#t(o),this.#i(n,s,r,o),n}#t(t){let{nodes:e,between:n,rows:s,columns:r,fineColumns:o}=this,{first:a,weights:l}=this.right;for(let c=0;c<s;c+=1){let h=c*r;for(let f=0;f<o;f+=1){let u=a[f],d=h+(u>0?u-1:0),g=h+Math.min(r-1,u+1),M=h+Math.min(r-1,u+2);n[c*o+f]=lx(e[d],e[h+u],e[g],e[M],l,4*f,t)}}}#i(t,e,n,s){let{between:r,rows:o,fineRows:a,fineColumns:l}=this,{first:c,weights:h}=this.down;for(let f=0;f<a;f+=1){let u=c[f],d=(u>0?u-1:0)*l,g=u*l,M=Math.min(o-1,u+1)*l,m=Math.min(o-1,u+2)*l;for(let p=0;p<l;p+=1)t[(f*l+p)*e+n]=lx(r[d+p],r[g+p],r[M+p],r[m+p],h,4*f,s)}}};function lx(i,t,e,n,s,r,o){let a=s[r]*i+s[r+1]*t+s[r+2]*e+s[r+3]*n;if(!o)return a;let l=t<e?t:e,c=t<e?e:t;return a<l?l:a>c?c:a}function fx(i,t,e,n=1){let s=Float32Array.from(e);for(let r=0;r<n;r+=1)s=cx(i,t,s,(o,a,l)=>Math.max(o,a,l));return cx(i,t,s,(r,o,a)=>(r+2*o+a)/4)}function cx(i,t,e,n){let s=new Float32Array(e.length),r=new Float32Array(e.length),o=(l,c,h)=>l[Math.min(i-1,Math.max(0,c))*t+Math.min(t-1,Math.max(0,h))],a=(l,c)=>{for(let h=0;h<i;h+=1)for(let f=0;f<t;f+=1)l[h*t+f]=c(h,f)};return a(s,(l,c)=>n(o(e,l,c-1),o(e,l,c),o(e,l,c+1))),a(r,(l,c)=>n(o(s,l-1,c),o(s,l,c),o(s,l+1,c))),r}function dx(i,t,e){let n=[];for(let s=0;s+1<i;s+=1)for(let r=0;r+1<t;r+=1){let o=s*t+r;Math.max(e[o],e[o+1],e[o+t],e[o+t+1])<=.5||n.push(o,o+1,o+t+1,o,o+t+1,o+t)}return Uint32Array.from(n)}var px=.07,iT=.3,sT=2;function mx(i,t){let e=Math.max(0,i);return t*(px+(iT-px)*e/(e+sT))}var rT=`
  attribute vec3 tail;
  attribute vec3 tip;
  attribute vec4 tint;    // w: 1 hollow
  uniform vec2 screen;    // px
  uniform float ratio;
  varying vec2 vAt;
  varying float vReach;
  varying vec4 vTint;
  void main() {
    vec4 a = projectionMatrix * modelViewMatrix * vec4(tail, 1.0);
    vec4 b = projectionMatrix * modelViewMatrix * vec4(tip, 1.0);
    vec2 along = (b.xy / b.w - a.xy / a.w) * screen * 0.5;
    vReach = length(along);
    along = vReach > 1e-3 ? along / vReach : vec2(0.0, -1.0);
    vec2 across = vec2(-along.y, along.x);
    float room = 16.0 * ratio;
    float end = position.x * 2.0 - 1.0;
    gl_Position = mix(a, b, position.x);
    vec2 off = along * end * room + across * position.y * room;
    vAt = vec2(position.x * vReach + end * room, position.y * room);
    gl_Position.xy += off / screen * 2.0 * gl_Position.w;
    gl_Position.z -= 5e-3 * gl_Position.w;  // its head is seen on a curved skin, too
    vTint = tint;
  }`,oT=`
  uniform vec3 casing;
  uniform float ratio;
  varying vec2 vAt;
  varying float vReach;
  varying vec4 vTint;
  // Distance to an arrow along x from 0 to reach, in px
  float arrow(vec2 p, float reach, float half_, float head, float wide) {
    p.y = abs(p.y);
    float edge = ((p.x - reach) * wide + p.y * head) / length(vec2(wide, head));
    float triangle = max(edge, reach - head - p.x);
    float end = max(reach - head + 1.0, 0.0);
    float shaft = length(vec2(p.x - clamp(p.x, 0.0, end), p.y)) - half_;
    return min(triangle, shaft);
  }
  void main() {
    float head = min(15.0 * ratio, max(vReach, 6.0 * ratio));
    float hollow = vTint.w;
    float wider = hollow * 4.2 * ratio;
    // What is wider all around still ends where it points to: 0.418 is the sine of half its angle
    float reach = vReach - wider / 0.418;
    float d = arrow(vAt, reach, 2.1 * ratio, head, 0.46 * head) - wider;
    float inside = 1.0 - smoothstep(-0.6, 0.6, d);
    float around = 1.0 - smoothstep(0.5 * ratio, 1.9 * ratio, d);
    float border = inside * smoothstep(-1.7 * ratio - 0.6, -1.7 * ratio + 0.6, d);
    vec3 colour = mix(casing, vTint.rgb, mix(inside, max(border, 0.8 * inside), hollow));
    float shell = max(border, max(0.28 * inside, 0.6 * around * (1.0 - inside)));
    float alpha = mix(max(inside, 0.75 * around), shell, hollow);
    if (alpha < 0.02) discard;
    gl_FragColor = vec4(colour, alpha);
  }`,Th=10,Ah=class{constructor(t=256){this.capacity=t,this.count=0,this.data=new Float32Array(Th*t);let e=new xr,n=new Float32Array([0,-1,0,1,-1,0,1,1,0,0,1,0]);e.setAttribute("position",new De(n,3)),e.setIndex([0,1,2,0,2,3]),this.buffer=new _r(this.data,Th),this.buffer.setUsage(ys);let s=(r,o)=>new mr(this.buffer,r,o);e.setAttribute("tail",s(3,0)),e.setAttribute("tip",s(3,3)),e.setAttribute("tint",s(4,6)),e.instanceCount=0,this.geometry=e,this.material=aT(),this.mesh=new Cn(e,this.material),this.mesh.frustumCulled=!1,this.mesh.renderOrder=6}clear(){this.count=0}add(t,e,n,s=!1){if(this.count>=this.capacity)return;let r=this.count*Th,{data:o}=this;for(let a=0;a<3;a+=1)o[r+a]=t[a],o[r+3+a]=e[a];o[r+6]=n.r,o[r+7]=n.g,o[r+8]=n.b,o[r+9]=s?1:0,this.count+=1}finish(){this.geometry.instanceCount=this.count,this.mesh.visible=this.count>0,this.buffer.clearUpdateRanges(),this.buffer.addUpdateRange(0,this.count*Th),this.buffer.needsUpdate=!0}setScreen(t,e,n){this.material.uniforms.screen.value.set(t,e),this.material.uniforms.ratio.value=n}setCasing(t){this.material.uniforms.casing.value.set(t)}};function aT(){return new mn({vertexShader:rT,fragmentShader:oT,transparent:!0,depthWrite:!1,side:On,uniforms:{screen:{value:new Jt(1,1)},ratio:{value:1},casing:{value:new Yt}}})}var gx=30,yd={x:44,y:50},lT=140,cT=[{name:"x",along:[1,0,0],colour:{dark:"#ff6369",light:"#cd2b31"}},{name:"y",along:[0,1,0],colour:{dark:"#4cc38a",light:"#18794e"}},{name:"z",along:[0,0,1],colour:{dark:"#849dff",light:"#3451b2"}}],Rh=class{setTheme(t){this.ink=new Yt(t.ink),this.text=t.ink;let e=t.bright?"light":"dark";this.axes=cT.map(({colour:n,...s})=>({...s,text:n[e],tint:new Yt(n[e])}))}draw(t,e,n,s,r){t.height<200||(this.#t(t,e,n),this.#i(t,e,n,`squares of ${Xo(s)}, depth ×${Gt(r,r<9.95?1:0)}`))}#t(t,e,n){let s=t.at(yd.x,t.height-yd.y),r=gx*t.pixel(t.distance),o=t.out(),a=({along:l})=>o.dot(new q(...l));for(let l of[...this.axes].sort((c,h)=>a(c)-a(h))){let c=new q(...l.along).multiplyScalar(r).add(s);e.add(s.toArray(),c.toArray(),l.tint,{width:2.5});let h=c.clone().sub(s).multiplyScalar(1.32).add(s).project(t.camera),f=l.name==="z"?`z ${t.upright?"up":"out"}`:l.name;n.push({key:`axis ${l.name}`,title:t.zUp?f:l.name,plain:l.text,middle:[(h.x+1)*.5*t.width,(1-h.y)*.5*t.height]})}}#i(t,e,n,s){let r=t.pixel(t.distance),o=ug(lT*r),[a,l]=[yd.x+gx+34,t.height-31],c=a+o/r,h=(f,u,d,g)=>e.add(t.at(f,u).toArray(),t.at(d,g).toArray(),this.ink,{width:2});h(a,l,c,l),h(a,l-4,a,l+4),h(c,l-4,c,l+4),n.push({key:"ruler",title:Xo(o),plain:this.text,left:[c+4,l]}),n.push({key:"ruling",title:s,plain:this.text,faint:!0,left:[a-4,l+17]})}};function xx([i,t,e],n=.9){let s=.5*(i+e),r=Math.hypot(.5*(i-e),t);if(!(s>0)||!(r<=s*(1+1e-9))||!Number.isFinite(s))return null;let o=Math.sqrt(-2*Math.log(1-n));return{a:o*Math.sqrt(s+r),b:o*Math.sqrt(Math.max(0,s-r)),angle:.5*Math.atan2(2*t,i-e)}}var Ph=[11,26,44,66,92,124,160],[_x,bd]=[14,8],Ch=16,vx=Math.PI/Ch,Sx=2e4,Mx=8e3,hT=500,Sd=Mx/4,uT=300,fT=150,dT=80,pT=5,mT=30;function wx(i,t,e,n){let s=bx(i,t,e,n),r=s.reduce((o,a)=>a.cost>o.cost?a:o,{cost:0});if(r.cost>dT&&r.cost<Sd)for(let o of i.length>pT?[r.label]:i){let a=[o,...i.filter(c=>c!==o)],l=bx(a,t,e,n);yx(l)<yx(s)&&(s=l)}for(let{label:o,x:a,y:l,taken:c,hidden:h}of s)Object.assign(o,{x:a,y:l,taken:c,hidden:h})}function yx(i){return i.reduce((t,{cost:e})=>t+e,0)}function bx(i,t,e,n){let s=[];return i.map(r=>{let o={label:r,cost:1/0,x:0,y:0,taken:0},a=(l,c,h)=>{r.x=Lh(l,4,e-r.width-4),r.y=Lh(c,4,n-r.height-4);let f=vT(r,s,t)+(h===r.taken?-mT:0);f<o.cost&&Object.assign(o,{cost:f,x:r.x,y:r.y,taken:h})};return gT(r,a),r.spare||xT(r,s,a),!r.spare&&o.cost>=Sd&&_T(r,e,n,a),o.hidden=o.cost>=(r.spare||r.brief?Sd:Sx),Object.assign(r,{x:o.x,y:o.y}),o.hidden||s.push(r),o})}function gT(i,t){let{anchorX:e,anchorY:n,width:s,height:r}=i,o=i.spare?1:Ph.length;for(let a=0;a<o;a+=1)for(let l=0;l<Ch;l+=1){let c=Ex(i)+l*2*Math.PI/Ch,[h,f]=[Math.cos(c),-Math.sin(c)],u=Math.min(s/2/Math.max(1e-9,Math.abs(h)),r/2/Math.max(1e-9,Math.abs(f))),d=Ph[a]+u;t(e+h*d-s/2,n+f*d-r/2,a*Ch+l)}}function xT(i,t,e){t.forEach((n,s)=>{for(let r of[n.x,i.anchorX+Ph[0],i.anchorX-Ph[0]-i.width])e(r,n.y-i.height-4,-1-2*s),e(r,n.y+n.height+4,-2-2*s)})}function _T(i,t,e,n){for(let s=0;s<=_x;s+=1)for(let r=0;r<=bd;r+=1){let[o,a]=[r/bd*(t-i.width),s/_x*(e-i.height)];n(o,a,1e3+s*(bd+1)+r)}}function Ex({side:i}){return i===0?Math.PI/2:i===2?-Math.PI/2:i>0?vx:Math.PI-vx}function vT(i,t,e){let[n,s]=Ih(i),{anchorX:r,anchorY:o}=i,a=Math.hypot(n-r,s-o),l=Math.atan2(o-i.y-i.height/2,i.x+i.width/2-r);a+=14*Math.acos(Math.cos(l-Ex(i)));for(let c of t){MT(i,yT(c))?a+=Sx:ST(r,o,n,s,c)&&(a+=uT);let[h,f]=Ih(c);Md(r,o,n,s,c.anchorX,c.anchorY,h,f)&&(a+=fT)}for(let c of e)a+=(c.light?hT:Mx)*bT(c,i);return a}function Ih({anchorX:i,anchorY:t,x:e,y:n,width:s,height:r}){return[Lh(i,e,e+s),Lh(t,n,n+r)]}function yT({x:i,y:t,width:e,height:n}){return{x:i-2,y:t-2,width:e+4,height:n+4}}function bT(i,t){let e=Math.min(i.x+i.width,t.x+t.width)-Math.max(i.x,t.x),n=Math.min(i.y+i.height,t.y+t.height)-Math.max(i.y,t.y);return e>0&&n>0?.25+.75*(e*n)/(i.width*i.height):0}function ST(i,t,e,n,{x:s,y:r,width:o,height:a}){return Md(i,t,e,n,s,r+a/2,s+o,r+a/2)||Md(i,t,e,n,s+o/2,r,s+o/2,r+a)}function Md(i,t,e,n,s,r,o,a){let l=(c,h,f,u,d,g)=>(f-c)*(g-h)-(u-h)*(d-c);return l(i,t,e,n,s,r)*l(i,t,e,n,o,a)<0&&l(s,r,o,a,i,t)*l(s,r,o,a,e,n)<0}function MT(i,t){return i.x<t.x+t.width&&t.x<i.x+i.width&&i.y<t.y+t.height&&t.y<i.y+i.height}function Lh(i,t,e){return Math.max(t,Math.min(i,Math.max(t,e)))}var Zs=300,wd=46,Nh='ui-sans-serif, system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif',wT=`
  uniform vec4 box;      // left, top, width, height in CSS px
  uniform vec2 screen;   // CSS px
  uniform vec2 part;     // of the canvas that is used
  varying vec2 vAt;
  void main() {
    vec2 at = box.xy + (position.xy * vec2(1.0, -1.0) + vec2(0.0, 1.0)) * box.zw;
    vAt = vec2(position.x * part.x, 1.0 - (1.0 - position.y) * part.y);
    gl_Position = vec4(at / screen * vec2(2.0, -2.0) + vec2(-1.0, 1.0), 0.0, 1.0);
  }`,ET=`
  uniform sampler2D text;
  varying vec2 vAt;
  void main() {
    gl_FragColor = texture2D(text, vAt);
  }`,Ed=class{constructor(t){this.canvas=document.createElement("canvas"),this.texture=null,this.written="",this.width=0,this.height=0,this.material=TT(),this.mesh=new Cn(Td,this.material),this.mesh.frustumCulled=!1,this.mesh.renderOrder=20,this.setRatio(t)}setRatio(t){this.ratio=t,this.canvas.width=Zs*t,this.canvas.height=wd*t,this.written="",this.texture?.dispose(),this.texture=new ha(this.canvas),this.texture.minFilter=on,this.texture.magFilter=on,this.texture.generateMipmaps=!1,this.texture.premultiplyAlpha=!0,this.material.uniforms.text.value=this.texture}write(t,e){let{title:n,aside:s,detail:r,accent:o,plain:a}=t,l=[n,s,r,o,a,e.panel].join(`
`);if(l===this.written)return;this.written=l;let c=this.canvas.getContext("2d");c.setTransform(this.ratio,0,0,this.ratio,0,0),c.clearRect(0,0,Zs,wd),a?this.#t(c,t,e):this.#i(c,t,e),this.texture.needsUpdate=!0}#t(t,{title:e,plain:n,faint:s},r){t.font=`${s?"":"600 "}12px ${Nh}`,this.width=Math.min(Zs,Math.ceil(t.measureText(e).width)+8),this.height=18,t.textBaseline="alphabetic",t.lineJoin="round",t.lineWidth=3,t.strokeStyle=r.background,t.globalAlpha=.85,t.strokeText(e,4,13.5),t.globalAlpha=1,t.fillStyle=n,t.fillText(e,4,13.5)}#i(t,{title:e,aside:n,second:s,detail:r,accent:o},a){let l=`600 14px ${Nh}`,c=`600 12px ${Nh}`,h=`12px ${Nh}`;t.font=l;let f=t.measureText(e).width,u=f;t.font=c,n&&(u+=10+t.measureText(n).width),t.font=h,u=Math.max(u,r?t.measureText(r).width:0),this.width=Math.min(Zs,Math.ceil((u+24)/8)*8),this.height=r?42:26,t.fillStyle=a.panel,t.strokeStyle=a.edge,t.lineWidth=1,t.beginPath(),t.roundRect(.5,.5,this.width-1,this.height-1,6),t.globalAlpha=.92,t.fill(),t.globalAlpha=1,t.stroke(),t.fillStyle=o,t.beginPath(),t.roundRect(5,6,3,this.height-12,1.5),t.fill(),t.textBaseline="alphabetic",t.fillStyle=a.ink,t.font=l,t.fillText(e,14,18,Zs-20),t.font=c,t.fillStyle=s??a.ink,n&&t.fillText(n,24+f,18,Zs-28-f),t.fillStyle=a.muted,t.font=h,r&&t.fillText(r,14,34,Zs-20)}show(t){let{uniforms:e}=this.material;this.mesh.visible=!this.hidden,e.box.value.set(Math.round(this.x),Math.round(this.y),this.width,this.height),e.part.value.set(this.width/Zs,this.height/wd),e.screen.value.copy(t)}},Td=new Fn;Td.setAttribute("position",new De(new Float32Array([0,0,0,1,0,0,1,1,0,0,1,0]),3));Td.setIndex([0,1,2,0,2,3]);var Dh=class{constructor(){this.group=new Yn,this.shown=new Map,this.spare=[],this.order=[],this.placed=[],this.ratio=1,this.screen=new Jt(1,1)}setScreen(t,e,n){if(this.screen.set(t,e),n!==this.ratio){this.ratio=n;for(let s of[...this.shown.values(),...this.spare])s.setRatio(n)}}set(t,e,n){let s=new Set(t.map(({key:o})=>o));for(let[o,a]of this.shown)s.has(o)||this.#i(o,a);let r=[];this.order.length=0;for(let o of t){let a=this.shown.get(o.key)??this.#t(o.key);a.write(o,n);let{anchorX:l,anchorY:c,side:h,spare:f,brief:u,accent:d}=o;Object.assign(a,{anchorX:l,anchorY:c,side:h,spare:f,brief:u,accent:d,hidden:!1}),this.order.push(a);let g=o.middle??o.left;g?(a.x=g[0]-(o.middle?a.width/2:0),a.y=g[1]-a.height/2,e.push(a)):r.push(a)}wx(r,e,this.screen.x,this.screen.y);for(let o of this.order)o.show(this.screen);this.placed=r}#t(t){let e=this.spare.pop()??new Ed(this.ratio);return e.taken=void 0,this.shown.set(t,e),this.group.add(e.mesh),e}#i(t,e){this.shown.delete(t),this.group.remove(e.mesh),this.spare.push(e)}};function TT(){return new mn({vertexShader:wT,fragmentShader:ET,transparent:!0,depthTest:!1,depthWrite:!1,blending:Pc,blendSrc:Ic,blendDst:_a,uniforms:{text:{value:null},box:{value:new qe},screen:{value:new Jt(1,1)},part:{value:new Jt(1,1)}}})}var AT=`
  attribute vec3 from;
  attribute vec3 to;
  attribute vec4 tint;
  attribute vec3 style;   // width in px, where its dashes begin and end (0, 0: none)
  uniform vec2 screen;    // px
  uniform float ratio;
  varying vec2 vAt;
  varying float vLong;
  varying float vHalf;
  varying vec4 vTint;
  varying vec2 vDash;
  void main() {
    vec4 a = projectionMatrix * modelViewMatrix * vec4(from, 1.0);
    vec4 b = projectionMatrix * modelViewMatrix * vec4(to, 1.0);
    vec2 pa = a.xy / a.w * screen * 0.5;
    vec2 pb = b.xy / b.w * screen * 0.5;
    vec2 along = pb - pa;
    vLong = length(along);
    along = vLong > 1e-4 ? along / vLong : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    vHalf = 0.5 * style.x * ratio;
    float reach = vHalf + 2.0 * ratio;
    vec4 end = mix(a, b, position.x);
    vec2 off = along * (position.x * 2.0 - 1.0) * reach + across * position.y * reach;
    vAt = vec2(position.x * vLong + (position.x * 2.0 - 1.0) * reach, position.y * reach);
    vTint = tint;
    vDash = style.yz;
    gl_Position = end;
    gl_Position.xy += off / screen * 2.0 * end.w;
    gl_Position.z -= 5e-4 * end.w;  // in front of the skin it lies on
  }`,RT=`
  uniform vec3 casing;
  uniform float below;    // 1: the casing, drawn before any line
  uniform float ratio;
  varying vec2 vAt;
  varying float vLong;
  varying float vHalf;
  varying vec4 vTint;
  varying vec2 vDash;
  void main() {
    float beyond = max(max(-vAt.x, vAt.x - vLong), 0.0);
    float away = length(vec2(beyond, vAt.y));
    if (vDash.y > vDash.x) {
      float at = mix(vDash.x, vDash.y, clamp(vAt.x / max(vLong, 1e-4), 0.0, 1.0));
      if (fract(at) > 0.55) discard;
    }
    float core = 1.0 - smoothstep(vHalf - 0.6, vHalf + 0.6, away);
    float around = 1.0 - smoothstep(vHalf + 0.4 * ratio, vHalf + 1.8 * ratio, away);
    vec4 colour = below > 0.5 ? vec4(casing, 0.6 * around) : vec4(vTint.rgb, core);
    colour.a *= vTint.a;
    if (colour.a < 0.02) discard;
    gl_FragColor = colour;
  }`,Uh=13,Pa=class{constructor(t=4096,{above:e=!1}={}){this.capacity=t,this.count=0,this.data=new Float32Array(Uh*t);let n=new xr,s=new Float32Array([0,-1,0,1,-1,0,1,1,0,0,1,0]);n.setAttribute("position",new De(s,3)),n.setIndex([0,1,2,0,2,3]),this.buffer=new _r(this.data,Uh),this.buffer.setUsage(ys);let r=(o,a)=>new mr(this.buffer,o,a);n.setAttribute("from",r(3,0)),n.setAttribute("to",r(3,3)),n.setAttribute("tint",r(4,6)),n.setAttribute("style",r(3,10)),n.instanceCount=0,this.geometry=n,this.materials=[Tx(1,e),Tx(0,e)],this.mesh=new Yn,this.materials.forEach((o,a)=>{let l=new Cn(n,o);l.frustumCulled=!1,l.renderOrder=(e?16:3)+a,this.mesh.add(l)})}clear(){this.count=0}add(t,e,n,{width:s=2,opacity:r=1,dash:o=null}={}){if(this.count>=this.capacity)return;let a=this.count*Uh,{data:l}=this;for(let c=0;c<3;c+=1)l[a+c]=t[c],l[a+3+c]=e[c];l[a+6]=n.r,l[a+7]=n.g,l[a+8]=n.b,l[a+9]=r,l[a+10]=s,l[a+11]=o?o[0]:0,l[a+12]=o?o[1]:0,this.count+=1}finish(){this.geometry.instanceCount=this.count,this.mesh.visible=this.count>0,this.buffer.clearUpdateRanges(),this.buffer.addUpdateRange(0,this.count*Uh),this.buffer.needsUpdate=!0}setCasing(t){for(let{uniforms:e}of this.materials)e.casing.value.set(t)}setScreen(t,e,n){for(let{uniforms:s}of this.materials)s.screen.value.set(t,e),s.ratio.value=n}};function Tx(i,t){return new mn({vertexShader:AT,fragmentShader:RT,transparent:!0,depthWrite:!1,depthTest:!t,side:On,uniforms:{screen:{value:new Jt(1,1)},ratio:{value:1},below:{value:i},casing:{value:new Yt("#0b0d12")}}})}var CT=32,Ax=8,Rx=3,PT=24,Cx=24,Px=14,Ix=480,IT=5,LT=.3,Fh=6,Oh=i=>new Yt(i);function NT(i,t,e){if(!e||!(t>0))return i;let n=i.map((r,o)=>t*r-e.vector[o]),s=Math.hypot(...n);return n.map(r=>r/s)}var Bh=class{constructor(t){this.patches=t,this.lines=new Pa,this.arrows=new Ah,this.labels=new Dh,this.group=new Yn,this.above=new Pa(256,{above:!0}),this.corner=new Rh,this.group.add(this.lines.mesh,this.arrows.mesh,this.above.mesh,this.labels.group),this.contacts=[],this.unit="N",this.truth=[],this.shapes=[],this.waiting=[],this.focus=null,this.tool=null,this.size=.1,this.labelled=!0,this.place={position:[0,0,0],normal:[0,0,1]},this.from={position:[0,0,0],normal:[0,0,1]},this.wanted=[],this.kept=[],this.covered=[],this.brief=!1,this.seen=new q,this.seenColour=new Yt,this.tail=new q}setScreen(t,e,n){this.lines.setScreen(t*n,e*n,n),this.above.setScreen(t*n,e*n,n),this.arrows.setScreen(t*n,e*n,n),this.labels.setScreen(t,e,n)}setTheme(t){this.theme=t,this.arrows.setCasing(t.background),this.lines.setCasing(t.casing),this.above.setCasing(t.background),this.corner.setTheme(t);let{contact:e,truth:n,muted:s,onSkin:r}=t;this.onSkin=Object.fromEntries(Object.entries(r).map(([o,a])=>[o,Oh(a)])),this.tint={contact:Oh(e),truth:Oh(n),old:Oh(s)}}draw(t){for(let s of[this.lines,this.arrows,this.above])s.clear();this.wanted.length=0,this.kept.length=0,this.kept.push(...this.covered),this.brief=t.width<Ix||this.contacts.length>IT,this.corner.draw(t,this.above,this.wanted,this.patches.ruling,this.patches.setView(t.out()));let e=Za(this.contacts,this.truth);for(let s of this.truth)this.#n(s,t);for(let s of this.shapes)this.#e(s);for(let s of this.waiting)this.#o(s,t);for(let s of e)this.#t(s,t);for(let s of Ja(e,this.truth))this.#a(s,t);for(let[s,r]of this.patches.all)this.#h(s,r,t);this.focus&&this.#S(this.focus),this.tool&&this.#b(this.tool,this.tool.radius,this.onSkin.tool,{opacity:.9}),this.lines.finish(),this.arrows.finish();let n=this.labelled?this.wanted:this.wanted.filter(({plain:s})=>s);this.labels.set(n,this.kept,this.theme);for(let s of this.labels.placed)this.#c(s,t);this.above.finish()}#t({contact:t,truth:e,error_m:n},s){let{old:r}=t;this.shapes.length||this.#A(t,r?this.tint.old:this.onSkin.contact);let o=r?0:this.#x(t),a=this.#r(t),l=this.#g(a,t,r?this.tint.old:this.tint.contact,!1,s);this.#l(t,Math.max(o,Math.sqrt((t.area||1e-5)/Math.PI)),s),this.#p(a.position,l,s);let c=t.maybe?` · ${Or(t.maybe)}?`:"";this.#u(`c${t.key}`,l,s,{title:`${Fo(t)} ${this.unit}${c}`,aside:e&&s.width>=Ix?`truth ${Gt(e.force,2)}`:"",second:this.theme.truth,detail:this.brief?"":this.#i(t,e&&!r?n:NaN),accent:r?this.theme.muted:this.theme.contact,side:1})}#i({track:t,old:e,seen:n,shear:s,...r},o){return e?`#${t}  ${n??"not of now"}`:[`#${t}  ${this.#f(r)}`,s&&`${Gt(s.size,2)} ${this.unit} along`,Number.isFinite(o)&&`${Gt(1e3*o)} off`].filter(Boolean).join(", ")}#n(t,e){let n=this.#r(t),s=this.#g(n,t,this.tint.truth,!0,e),r=t.contact_radius||t.radius||.002;this.#l(t,r,e),this.#p(n.position,s,e),t.border?this.#s(t,t.border,[t.x,t.y,0],this.onSkin.truth,{dashed:!0}):this.#b(t,r,this.onSkin.truth,{dashed:!0,rest:!0})}#e({patch:t,pose:e,outline:n}){for(let s of n)this.#s({patch:t},s,e,this.onSkin.contact,{width:2.6})}#s({patch:t},e,[n,s,r],o,a){if(e.length<2)return;let[l,c,h]=[Math.cos(r),Math.sin(r),e.length-1],f=h*(a.dashed?Math.ceil(2*Cx/h):1);this.#v(f,t,o,{width:2,rest:!0,...a},(u,d)=>{let g=Math.min(Math.floor(u*h),h-1),[M,m]=[0,1].map(p=>e[g][p]+(u*h-g)*(e[g+1][p]-e[g][p]));d[0]=n+l*M-c*m,d[1]=s+c*M+l*m})}#a(t,e){let n=this.#r(t);this.#u(`t${t.id}`,this.#m(n,t,e),e,{title:`truth ${Gt(t.force,2)} N`,detail:this.brief?"not found":`${this.#f(t)}  not found`,accent:this.theme.truth,side:-1})}#r({patch:t,x:e,y:n,position:s,normal:r}){let{place:o}=this;return this.patches.at(t,e,n,o,!0)||(o.position=[...s],o.normal=[...r]),o}#o({id:t,position:e,why:n},s){this.#u(`w${t}`,this.seen.set(...e).clone(),s,{title:"the press waits",detail:n,accent:this.theme.truth,side:-1})}#h(t,{answer:e,waiting:n,surface:s,about:r},o){if(!s)return;let a=e==="missing"&&!n,{centre:l}=s.nodes.sphere;if(a){this.#u(`m${t}`,this.seen.set(...l).clone(),o,{title:r.name,detail:"no reading",accent:this.theme.muted,side:0});return}if(!s.faces(o.camera.position))return;let[c,h]=this.patches.foot(t,u=>this.#d(this.seen.set(...u),o)),f={plain:this.theme.muted,faint:!0,side:2,spare:!0};this.patches.all.size!==1&&this.wanted.push({key:`n${t}`,title:r.name,...f,anchorX:c,anchorY:h-8})}#u(t,e,n,s){let[r,o]=this.#d(e,n);Math.abs(this.seen.z)>1||this.wanted.push({key:t,...s,brief:this.brief,anchorX:r,anchorY:o})}#c(t,e){if(t.hidden||!t.accent)return;let[n,s]=Ih(t);if(Math.hypot(n-t.anchorX,s-t.anchorY)<4)return;let r=[e.at(t.anchorX,t.anchorY),e.at(n,s)].map(o=>o.toArray());this.above.add(...r,this.seenColour.set(t.accent),{width:1.5})}#f({patch:t,x:e,y:n}){let{all:s}=this.patches;return`${s.size>1?`${s.get(t)?.about.name??t}  `:""}x ${Gt(1e3*e)}  y ${Gt(1e3*n)} mm`}#l({patch:t,x:e,y:n,position:s},r,o){let a={position:[...s],normal:[0,0,1]},l=[];for(let d=0;d<Ax;d+=1){let g=d*2*Math.PI/Ax;this.patches.at(t,e+r*Math.cos(g),n+r*Math.sin(g),a,!0),l.push(this.#d(this.seen.set(...a.position),o))}let[c,h]=[0,1].map(d=>Math.min(...l.map(g=>g[d]))-Rx),[f,u]=[0,1].map(d=>Math.max(...l.map(g=>g[d]))+Rx);this.kept.push({x:c,y:h,width:f-c,height:u-h})}#p(t,e,n){let[s,r]=this.#d(this.seen.set(...t),n),[o,a]=this.#d(e,n);for(let l=0;l<4;l+=1){let[c,h]=[s+(l+.5)/4*(o-s),r+(l+.5)/4*(a-r)],[f,u]=[Math.max(14,Math.abs(o-s)/4),Math.max(10,Math.abs(a-r)/4)];this.kept.push({x:c-f/2,y:h-u/2,width:f,height:u,light:!0})}}#d(t,e){let{seen:n}=this;return n.copy(t).project(e.camera),[(n.x+1)*.5*e.width,(1-n.y)*.5*e.height]}#g(t,e,n,s,r){let o=this.#m(t,e,r);return this.arrows.add(o.toArray(),t.position,n,s),o}#m({position:t,normal:e},{patch:n,force:s,shear:r},o){let a=this.patches.all.get(n)?.about.side||this.size,l=mx(Math.hypot(s,r?.size??0),Math.min(this.size,1.8*a)),{tail:c}=this,h=NT(e,s,r);for(let f of[1,.85,.7,.55,.4]){c.set(...t).addScaledVector(this.seen.set(...h),f*l);let[u,d]=this.#d(c,o);if(u>Fh&&d>Fh&&u<o.width-Fh&&d<o.height-Fh)break}return c}#x({patch:t,x:e,y:n,place_cov:s}){let r=s&&xx(s);if(!r||!(r.a>0)||r.a>LT*this.size)return 0;let{a:o,b:a,angle:l}=r,[c,h]=[Math.cos(l),Math.sin(l)],f={width:1.2,opacity:.85,rest:!0};return this.#v(PT,t,this.onSkin.contact,f,(u,d)=>{let[g,M]=[o*Math.cos(2*Math.PI*u),a*Math.sin(2*Math.PI*u)];d[0]=e+c*g-h*M,d[1]=n+h*g+c*M}),Math.max(o,a)}#b({patch:t,x:e,y:n},s,r,{dashed:o=!1,opacity:a=1,rest:l=!1}={}){this.#v(CT,t,r,{dashed:o,opacity:a,width:2,rest:l},(c,h)=>{h[0]=e+s*Math.cos(2*Math.PI*c),h[1]=n+s*Math.sin(2*Math.PI*c)})}#S({patch:t,low:e,high:n}){let s=[[e[0],e[1]],[n[0],e[1]],[n[0],n[1]],[e[0],n[1]]];for(let r=0;r<4;r+=1){let[o,a]=s[r],[l,c]=s[(r+1)%4];this.#v(Cx,t,this.onSkin.focus,{width:2},(h,f)=>{f[0]=o+(l-o)*h,f[1]=a+(c-a)*h})}}#v(t,e,n,{dashed:s=!1,rest:r=!1,...o},a){let l=[0,0],[c,h]=[this.from,this.place];a(0,l);let f=this.patches.at(e,l[0],l[1],c,r);for(let u=1;u<=t;u+=1){a(u/t,l);let d=this.patches.at(e,l[0],l[1],h,r),g=s?[(u-1)/t*Px,u/t*Px]:null;(f||d)&&this.lines.add(c.position,h.position,n,{...o,dash:g}),[c,h,f]=[h,c,d]}}#A({patch:t,x:e,y:n,position:s,outline:r},o){if(!r||r.length<2)return;let a=this.#_(t,e,n);if(!a)return;let[l,c]=a,h=(f,u)=>{let d=r[Math.round(f*r.length)%r.length],g=[d[0]-s[0],d[1]-s[1],d[2]-s[2]];u[0]=e+g[0]*l[0]+g[1]*l[1]+g[2]*l[2],u[1]=n+g[0]*c[0]+g[1]*c[1]+g[2]*c[2]};this.#v(r.length,t,o,{width:2,rest:!0},h)}#_(t,e,n){let r=[];for(let[o,a]of[[1e-4,0],[0,1e-4]]){let l={position:[0,0,0],normal:[0,0,1]},c={position:[0,0,0],normal:[0,0,1]};this.patches.at(t,e-o,n-a,l,!0),this.patches.at(t,e+o,n+a,c,!0);let h=c.position.map((u,d)=>u-l.position[d]),f=Math.hypot(...h);if(!(f>0))return null;r.push(h.map(u=>u/f))}return r}};function Lx(i){let t=[];for(let n=0;n+1<i.length;n+=2)t.push([i[n],i[n+1]]);if(t.sort((n,s)=>n[0]-s[0]||n[1]-s[1]),t.length<3)return Float64Array.from(t.flat());let e=n=>{let s=[];for(let r of n){for(;s.length>1&&DT(s.at(-2),s.at(-1),r)<=0;)s.pop();s.push(r)}return s.pop(),s};return Float64Array.from([...e(t),...e([...t].reverse())].flat())}function DT(i,t,e){return(t[0]-i[0])*(e[1]-i[1])-(t[1]-i[1])*(e[0]-i[0])}function Nx(i,t,e){let n=i.length/2,s=1/0,r=n>2;for(let o=0;o<n;o+=1){let a=(o+1)%n,l=i[2*o],c=i[2*o+1],h=i[2*a]-l,f=i[2*a+1]-c,u=h*h+f*f||1,d=Math.max(0,Math.min(1,((t-l)*h+(e-c)*f)/u));s=Math.min(s,Math.hypot(t-l-d*h,e-c-d*f)),h*(e-c)-f*(t-l)<0&&(r=!1)}return r?s:-s}var UT=.42,Ad=class{constructor(t,e){this.hull=t,this.margin=e}pad(t){let e=Math.abs(t[2]-t[0])||this.margin;return Math.min(6,Math.ceil(this.margin/e)+1)}trim(t,e,n){for(let s=0;s<t.length;s+=1){let r=Nx(this.hull,e[2*s],e[2*s+1])+this.margin;t[s]=Math.min(t[s],.5+r/n)}}};function Dx(i,t){if(!i.taxels?.length||!(t>0))return null;let e=[];for(let n=0;n<i.taxels.length;n+=3)e.push(...FT(i,n));return new Ad(Lx(e),UT*t)}function FT({taxels:i,positions:t,plane:e},n){let s=0,r=1/0,o=(l,c)=>i[n+c]-t[3*l+c];for(let l=0;l<e.length/2;l+=1){let c=o(l,0)**2+o(l,1)**2+o(l,2)**2;c<r&&([r,s]=[c,l])}return[0,1].map(l=>e[2*s+l]+a(l));function a(l){let c=OT(e,s,l);if(c<0)return 0;let h=e[2*c+l]-e[2*s+l],f=0;for(let u=0;u<3;u+=1)f+=o(s,u)*(t[3*c+u]-t[3*s+u])/h;return f}}function OT(i,t,e){let n=i.length/2,s=1;for(;s<n&&i[2*s+1]===i[1];)s+=1;let r=e===0?1:s,o=Math.floor(t/s);for(let a of[t+r,t-r])if(!(a<0||a>=n)&&!(e===0&&Math.floor(a/s)!==o))return a;return-1}var Ux=255;var BT=`
  attribute vec3 outward;
  attribute float reading;
  attribute float repaired;
  attribute float height;
  uniform float depth;
  uniform float size;      // px at the distance of one metre
  uniform float lift;      // m
  uniform float large;     // 1: the taxels are what is looked at
  uniform float shown;     // 0: only those that are dead
  varying float vReading;
  varying float vRepaired;
  varying float vSize;
  void main() {
    vec3 sunk = position - outward * height * depth;
    vec4 seen = modelViewMatrix * vec4(sunk, 1.0);
    float facing = dot(normalMatrix * outward, -seen.xyz);
    gl_Position = projectionMatrix * seen;
    // A dot faces the camera while the skin leans: lifted, lest half of it sinks in
    vec4 lifted = projectionMatrix * (seen + vec4(0.0, 0.0, lift, 0.0));
    gl_Position.z = lifted.z / lifted.w * gl_Position.w;
    bool hidden = shown < 0.5 && reading * 255.0 < 254.5;
    if (facing <= 0.0 || hidden) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    vReading = reading * 255.0;
    vRepaired = repaired * 255.0;
    float dead = step(254.5, vReading);
    float level = min(vReading / 254.0, 1.0) * (1.0 - dead);
    float share = mix(0.14 + 0.14 * level, 0.62, large);
    vSize = max(4.0, size / -seen.z * mix(share, mix(0.42, 0.62, large), dead));
    gl_PointSize = vSize;
  }`,kT=`
  uniform sampler2D map;
  uniform vec3 dead;
  uniform vec3 rim;
  uniform vec3 plain;   // of a taxel that is not what is looked at
  uniform float large;
  uniform float full;   // what the strongest reading stands for
  uniform vec2 bar;     // ends of the colour bar
  varying float vReading;
  varying float vRepaired;
  varying float vSize;
  vec3 colourOf(float reading) {
    float shade = clamp((reading / 254.0 * full - bar.x) / max(bar.y - bar.x, 1e-30), 0.0, 1.0);
    return texture2D(map, vec2((shade * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  }
  void main() {
    vec2 at = gl_PointCoord * 2.0 - 1.0;
    float soft = 2.0 / vSize;
    if (vReading > 254.5) {
      float arm = min(abs(at.x - at.y), abs(at.x + at.y)) * 0.7071;
      float wide = max(0.16, 1.1 * soft);
      float inside = 1.0 - smoothstep(wide, wide + soft, arm);
      float casing = 1.0 - smoothstep(wide + 0.16, wide + 0.16 + soft, arm);
      float within = 1.0 - smoothstep(1.0 - soft, 1.0, length(at));
      gl_FragColor = vec4(mix(vec3(0.05), dead, inside), within * max(inside, 0.55 * casing));
      if (vRepaired < 254.5) gl_FragColor = vec4(mix(colourOf(vRepaired), dead, inside), within);
    } else {
      float r = length(at);
      float inside = 1.0 - smoothstep(1.0 - 1.5 * soft, 1.0, r);
      float level = vReading / 254.0;
      vec3 colour = colourOf(vReading);
      float ring = smoothstep(1.0 - 3.2 * soft, 1.0 - 2.2 * soft, r);
      vec4 wide = vec4(mix(colour, rim, ring), 1.0);
      vec4 small = vec4(plain, mix(0.26, 0.9, level));
      gl_FragColor = mix(small, wide, large);
      gl_FragColor.a *= inside;
    }
    if (gl_FragColor.a < 0.02) discard;
  }`,kh=class{constructor(t,e,n,s){this.count=t.length/3,this.positions=Float32Array.from(t),this.pitch=n;let r=new Fn;r.setAttribute("position",new De(this.positions,3)),r.setAttribute("outward",new De(Float32Array.from(e),3)),this.reading=Rd(new Uint8Array(this.count)),this.repaired=Rd(new Uint8Array(this.count).fill(Ux)),this.height=Rd(new Float32Array(this.count),!1),r.setAttribute("reading",this.reading),r.setAttribute("repaired",this.repaired),r.setAttribute("height",this.height),this.material=VT(s),this.material.uniforms.lift.value=.4*n,this.mesh=new la(r,this.material),this.mesh.frustumCulled=!1,this.mesh.renderOrder=2,this.nodes=null,this.corners=new Uint32Array(this.count)}setReadings(t,e){this.reading.array.set(t.length===this.count?t:[]),this.reading.needsUpdate=!0,e?.length===this.count?this.repaired.array.set(e):this.repaired.array.fill(Ux),this.repaired.needsUpdate=!0}follow(t){let{nodes:e}=t;this.nodes!==e&&this.#t(e),this.setDepth(t.scale);for(let n=0;n<this.count;n+=1)this.height.array[n]=e.height[this.corners[n]];this.height.needsUpdate=!0}setDepth(t){this.material.uniforms.depth.value=t}#t(t){this.nodes=t;for(let e=0;e<this.count;e+=1)this.corners[e]=zT(t,this.positions,3*e)}setColours(t,e){this.material.uniforms.full.value=t,this.material.uniforms.bar.value.set(...e)}show(t,e){this.material.uniforms.shown.value=t?1:0,this.material.uniforms.large.value=e?1:0}setTheme({rim:t,dot:e}){this.material.uniforms.rim.value.set(t),this.material.uniforms.plain.value.set(e)}setSize(t){this.material.uniforms.size.value=t*this.pitch}dispose(){this.mesh.geometry.dispose(),this.material.dispose()}};function Rd(i,t=!0){let e=new De(i,1,t);return e.setUsage(ys),e}function zT(i,t,e){let n=0,s=1/0;for(let r=0;r<i.count;r+=1){let o=i.positions[3*r]-t[e],a=i.positions[3*r+1]-t[e+1],l=i.positions[3*r+2]-t[e+2],c=o*o+a*a+l*l;c<s&&(s=c,n=r)}return n}function VT(i){return new mn({vertexShader:BT,fragmentShader:kT,transparent:!0,depthWrite:!1,uniforms:{map:{value:i},depth:{value:0},size:{value:1},lift:{value:0},large:{value:0},full:{value:1},bar:{value:new Jt(0,1)},shown:{value:1},dead:{value:new Yt(fp)},plain:{value:new Yt("#ffffff")},rim:{value:new Yt}}})}var zh=class{constructor(t,e,n=0){let{rows:s,columns:r}=t;this.patch=t.patch,this.rung=t.rung,this.given=s*r,this.rows=s+2*n,this.columns=r+2*n,this.count=this.rows*this.columns,this.positions=Cd(e.positions,3,s,r,n),this.normals=GT(Cd(e.normals,3,s,r,n)),this.plane=Cd(e.plane,2,s,r,n),this.covered=new Uint8Array(this.count);for(let o=0;o<this.given;o+=1){let a=Math.floor(o/r)+n;this.covered[a*this.columns+o%r+n]=e.covered[o]?1:0}this.source=WT(this,s,r,n),this.origin=[this.plane[0],this.plane[1]],this.pitch=HT(this),this.height=new Float32Array(this.count),this.flat=!0,this.sunk=new Float32Array(3*this.count),this.sphere=XT(this.positions,this.covered)}setHeight(t,e=0){if(t)for(let n=0;n<this.count;n+=1)this.height[n]=t[this.source[n]]-e;else this.flat||this.height.fill(0);this.flat=!t}at(t,e,n,s){let r=(t-this.origin[0])/this.pitch,o=(e-this.origin[1])/this.pitch,a=Fx(r,0,this.columns-1),l=Fx(o,0,this.rows-1),c=Math.min(Math.floor(a),Math.max(0,this.columns-2)),h=Math.min(Math.floor(l),Math.max(0,this.rows-2)),f=h*this.columns+c,u=this.columns>1?1:0,d=this.rows>1?this.columns:0,g=[f,f+u,f+d,f+d+u],[M,m]=[a-c,l-h],p=[(1-M)*(1-m),M*(1-m),(1-M)*m,M*m],{position:y,normal:A}=s;y.fill(0),A.fill(0);let w=0;for(let T=0;T<4;T+=1){w+=p[T]*this.height[g[T]];for(let _=0;_<3;_+=1)y[_]+=p[T]*this.positions[3*g[T]+_],A[_]+=p[T]*this.normals[3*g[T]+_]}let P=Math.hypot(A[0],A[1],A[2])||1;for(let T=0;T<3;T+=1)A[T]/=P,y[T]-=A[T]*w*n;return Math.abs(a-r)>.5||Math.abs(l-o)>.5?!1:g.some(T=>this.covered[T]===1)}hit(t,e,n){let s=65535*n;if(!qT(t,e,this.sphere,this.flat?0:s))return null;let r=this.#t(n),o={distance:1/0,x:0,y:0};for(let a=0;a+1<this.rows;a+=1)for(let l=0;l+1<this.columns;l+=1){let c=a*this.columns+l,h=c+this.columns;(this.covered[c]||this.covered[c+1]||this.covered[h]||this.covered[h+1])&&(this.#i(r,t,e,c,c+1,h+1,o),this.#i(r,t,e,c,h+1,h,o))}return o.distance<1/0?o:null}#t(t){if(this.flat||t===0)return this.positions;let{sunk:e,positions:n,normals:s,height:r}=this;for(let o=0;o<this.count;o+=1){let a=r[o]*t;for(let l=3*o;l<3*o+3;l+=1)e[l]=n[l]-s[l]*a}return e}#i(t,e,n,s,r,o,a){let l=t[3*s],c=t[3*s+1],h=t[3*s+2],f=t[3*r]-l,u=t[3*r+1]-c,d=t[3*r+2]-h,g=t[3*o]-l,M=t[3*o+1]-c,m=t[3*o+2]-h,p=n[1]*m-n[2]*M,y=n[2]*g-n[0]*m,A=n[0]*M-n[1]*g,w=f*p+u*y+d*A;if(Math.abs(w)<1e-18)return;let P=e[0]-l,T=e[1]-c,_=e[2]-h,E=(P*p+T*y+_*A)/w;if(E<0||E>1)return;let V=T*d-_*u,D=_*f-P*d,L=P*u-T*f,H=(n[0]*V+n[1]*D+n[2]*L)/w;if(H<0||E+H>1)return;let G=(g*V+M*D+m*L)/w;if(G<=0||G>=a.distance)return;let N=this.normals;if(n[0]*N[3*s]+n[1]*N[3*s+1]+n[2]*N[3*s+2]>=0)return;let z=this.plane;a.distance=G,a.x=z[2*s]*(1-E-H)+z[2*r]*E+z[2*o]*H,a.y=z[2*s+1]*(1-E-H)+z[2*r+1]*E+z[2*o+1]*H}};function Fx(i,t,e){return i<t?t:i>e?e:i}function HT({plane:i,columns:t,rows:e}){return t>1?i[2]-i[0]:e>1?i[2*t+1]-i[1]:1}function Cd(i,t,e,n,s){let r=n+2*s,o=new Float32Array(t*r*(e+2*s)),a=(c,h,f)=>i[(c*n+h)*t+f],l=(c,h,f)=>Ox(u=>a(c,u,f),h,n);for(let c=-s;c<e+s;c+=1)for(let h=-s;h<n+s;h+=1){let f=((c+s)*r+h+s)*t;for(let u=0;u<t;u+=1)o[f+u]=Ox(d=>l(d,h,u),c,e)}return o}function Ox(i,t,e){if(t>=0&&t<e)return i(t);let n=t<0?0:e-1,s=t<0?Math.min(1,e-1):Math.max(0,e-2),r=i(n);return r+Math.abs(t-n)*(r-i(s))}function GT(i){for(let t=0;t<i.length;t+=3){let e=Math.hypot(i[t],i[t+1],i[t+2])||1;for(let n=t;n<t+3;n+=1)i[n]/=e}return i}function WT(i,t,e,n){let s=i.columns,r=(o,a)=>Math.min(a-1,Math.max(0,o-n));return ux(i.rows,s,i.covered,n+3).map(o=>r(Math.floor(o/s),t)*e+r(o%s,e))}function XT(i,t){let e=[1/0,1/0,1/0],n=[-1/0,-1/0,-1/0];for(let r=0;r<t.length;r+=1)if(t[r])for(let o=0;o<3;o+=1)e[o]=Math.min(e[o],i[3*r+o]),n[o]=Math.max(n[o],i[3*r+o]);return e[0]>n[0]?{centre:[0,0,0],radius:0}:{centre:e.map((r,o)=>(r+n[o])/2),radius:.55*Math.hypot(...n.map((r,o)=>r-e[o]))}}function qT(i,t,{centre:e,radius:n},s){let r=0,o=0;for(let l=0;l<3;l+=1){let c=e[l]-i[l];r+=c*t[l],o+=c*c}let a=n*1.1+s;return o-r*r<=a*a}var $T=3,Bx=.9,YT=`
  attribute vec3 outward;
  attribute vec3 along;    // the plane's first axis
  attribute float cover;
  attribute float height;
  attribute float colour;
  attribute vec2 slope;
  attribute vec2 place;
  uniform float depth;
  uniform vec3 mean;       // outer side of the patch as a whole; short where it closes around
  varying float vCover;
  varying float vColour;
  varying vec2 vPlace;
  varying float vFacing;
  varying vec2 vLit;       // by the light, and by its gloss, beyond what the skin at rest gets
  const vec3 KEY = vec3(-0.75, 0.36, 0.555);  // of the camera: from its left, above and behind it
  float gloss(vec3 normal, vec3 eye) {
    return pow(max(dot(normal, normalize(KEY + eye)), 0.0), 28.0);
  }
  void main() {
    vec3 sunk = position - outward * (height * depth);
    vec4 seen = modelViewMatrix * vec4(sunk, 1.0);
    vec3 across = cross(outward, along);
    vec3 lean = (along * slope.x + across * slope.y) * depth * ${$T.toFixed(1)};
    lean /= sqrt(1.0 + dot(lean, lean) / ${(Bx*Bx).toFixed(2)});
    vCover = cover;
    vColour = colour;
    vPlace = place;
    vec3 eye = normalize(-seen.xyz);
    vec3 rest = normalize(normalMatrix * outward);
    vec3 normal = normalize(normalMatrix * (outward + lean));
    vFacing = dot(rest, eye);
    vLit = vec2(dot(normal - rest, KEY), max(gloss(normal, eye) - gloss(rest, eye), 0.0));
    vLit.x += 0.3 * dot(rest - normalMatrix * mean, KEY);  // nothing where the skin is flat
    gl_Position = projectionMatrix * seen;
  }`,ZT=`
  uniform sampler2D map;
  uniform vec2 span;      // what colour 0 and 1 stand for
  uniform vec2 bar;       // ends of the colour bar
  uniform vec3 grey;
  uniform vec3 rim;
  uniform vec3 ink;       // of the ruled squares
  uniform float plain;    // 1: no colours of the map
  uniform float missing;  // 1: no reading
  varying float vCover;
  varying float vColour;
  varying vec2 vPlace;
  varying float vFacing;
  varying vec2 vLit;
  void main() {
    float soft = fwidth(vCover) + 1e-5;
    float inside = clamp((vCover - 0.5) / soft + 0.5, 0.0, 1.0);
    if (inside <= 0.0) discard;
    float edge = 1.0 - clamp((vCover - 0.5) / (2.2 * soft), 0.0, 1.0);
    vec2 wide = fwidth(vPlace) + 1e-6;  // of a pixel, in squares
    vec2 cell = abs(fract(vPlace) - 0.5) / wide;
    float line = 1.0 - min(min(cell.x, cell.y), 1.0);
    line *= 1.0 - smoothstep(0.10, 0.22, max(wide.x, wide.y));
    if (vFacing < 0.0) {
      // Seen from inside: outlines only, which hide nothing behind them
      float seen = max(edge * inside, 0.2 * line);
      if (seen < 0.03) discard;
      gl_FragColor = vec4(rim, 0.6 * seen);
      return;
    }
    float value = span.x + vColour * (span.y - span.x);
    float at = clamp((value - bar.x) / max(bar.y - bar.x, 1e-30), 0.0, 1.0);
    vec3 colour = texture2D(map, vec2((at * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    colour = mix(colour, grey, max(plain, missing));
    colour = mix(colour, ink, 0.09 * line * (1.0 - missing));
    colour *= 1.0 + 0.55 * min(vLit.x, 0.0);
    colour += (1.0 - colour) * 0.40 * max(vLit.x, 0.0);
    colour += 0.16 * vLit.y;
    if (missing > 0.5) {
      float stripe = abs(fract((vPlace.x + vPlace.y) * 0.7) - 0.5);
      colour = mix(colour, rim, 0.35 * smoothstep(0.20, 0.25, stripe));
    }
    colour = mix(colour, rim, edge);
    colour *= 0.84 + 0.16 * smoothstep(0.0, 0.42, vFacing);  // rounds off a limb's sides
    gl_FragColor = vec4(colour, inside);
  }`,Vh=class{constructor(t,e,{table:n,patches:s,finest:r,border:o,ruling:a}){this.pad=o?.pad(e.plane)??1,this.nodes=new zh(t,e,this.pad),this.border=o,this.ruling=a;let{rows:l,columns:c}=this.nodes,h=hx(t.rows,t.columns,s,r);this.refiner=new Eh(l,c,h),this.geometry=this.#t(),this.material=jT(n),this.mean=JT(this.nodes),this.material.uniforms.mean.value.copy(this.mean),this.mesh=new Cn(this.geometry,this.material),this.mesh.frustumCulled=!1,this.leans=new Float32Array(2*this.nodes.count),this.heightScale=0,this.exaggeration=1,this.steepness=0,this.steepest=1/0}#t(){let{nodes:t,refiner:e}=this,n=new Float32Array(e.count),s=fx(t.rows,t.columns,t.covered,this.pad);e.apply(s,null,n);let r=(f,u)=>{let d=new Float32Array(u*e.count);for(let g=0;g<u;g+=1)e.apply(f,null,d,{stride:u,offset:g,bounded:!1});return new De(d,u)},o=r(t.plane,2);this.border?.trim(n,o.array,4*t.pitch);let a=new Fn,l=dx(e.fineRows,e.fineColumns,n);a.setIndex(new De(l,1));let c=r(t.positions,3);a.setAttribute("position",c),a.setAttribute("outward",r(t.normals,3)),a.setAttribute("along",QT(c.array,e));let h=o.array.map(f=>f/this.ruling);return a.setAttribute("place",new De(h,2)),a.setAttribute("cover",new De(n,1)),a.setAttribute("height",Pd(new Float32Array(e.count),!1)),a.setAttribute("colour",Pd(new Uint16Array(e.count),!0)),a.setAttribute("slope",Pd(new Float32Array(2*e.count),!1,2)),a}setHeight(t,e,n=0){let s=this.nodes.flat;if(this.nodes.setHeight(t,n),this.heightScale=e||0,this.steepness=t?tA(this.nodes,this.leans):0,this.#i(),!t&&s)return;let{height:r,slope:o}=this.geometry.attributes;if(t){this.refiner.apply(this.nodes.height,null,r.array);for(let a of[0,1])this.refiner.apply(this.leans,null,o.array,{stride:2,offset:a,bounded:!1})}else r.array.fill(0),o.array.fill(0);r.needsUpdate=!0,o.needsUpdate=!0}setColour(t,e,n){let s=this.geometry.attributes.colour;this.material.uniforms.span.value.set(e,n),t?this.refiner.apply(t,this.nodes.source,s.array):s.array.fill(0),s.needsUpdate=!0}setExaggeration(t){this.exaggeration=t,this.#i()}setView(t){this.steepest=fg(t.dot(this.mean)/(this.mean.length()||1)),this.#i()}get times(){let t=this.steepness*this.heightScale;return t>0?Math.min(this.exaggeration,this.steepest/t):this.exaggeration}get scale(){return this.heightScale*this.times}#i(){this.material.uniforms.depth.value=this.scale}faces(t){let{centre:e}=this.nodes.sphere;return t.clone().sub(new q(...e)).dot(this.mean)>=0}get rim(){return this.edge??=KT(this.geometry.attributes),this.edge}dispose(){this.geometry.dispose(),this.material.dispose()}};function JT({normals:i,covered:t}){let e=new q,n=0;for(let s=0;s<t.length;s+=1)t[s]&&(e.x+=i[3*s],e.y+=i[3*s+1],e.z+=i[3*s+2],n+=1);return e.divideScalar(Math.max(1,n))}function KT({position:i,cover:t,place:e}){let n=new Map;for(let s=0;s<24;s+=1){let[r,o]=[Math.cos(s*Math.PI/12),Math.sin(s*Math.PI/12)],[a,l]=[0,-1/0];for(let c=0;c<t.count;c+=1){let h=r*e.array[2*c]+o*e.array[2*c+1];t.array[c]>=.5&&h>l&&([a,l]=[c,h])}n.set(a,Array.from(i.array.subarray(3*a,3*a+3)))}return[...n.values()]}function Pd(i,t,e=1){let n=new De(i,e,t);return n.setUsage(ys),n}function jT(i){return new mn({vertexShader:YT,fragmentShader:ZT,side:On,transparent:!0,depthWrite:!0,uniforms:{map:{value:i},span:{value:new Jt(0,0)},bar:{value:new Jt(0,1)},grey:{value:new Yt},rim:{value:new Yt},depth:{value:0},mean:{value:new q},plain:{value:0},missing:{value:0},ink:{value:new Yt}}})}function QT(i,{fineRows:t,fineColumns:e}){let n=new Float32Array(i.length);for(let s=0;s<t*e;s+=1){let r=s%e,o=3*(r>0?s-1:s),a=3*(r+1<e?s+1:s),l=[0,1,2].map(h=>i[a+h]-i[o+h]),c=Math.hypot(...l)||1;for(let h=0;h<3;h+=1)n[3*s+h]=l[h]/c}return new De(n,3)}function tA({height:i,rows:t,columns:e,pitch:n},s){let r=1/(2*n),o=0;for(let a=0;a<t;a+=1){let l=Math.min(t-1,a+1)*e,c=Math.max(0,a-1)*e;for(let h=0;h<e;h+=1){let f=a*e+h,u=i[a*e+Math.min(e-1,h+1)],d=i[a*e+Math.max(0,h-1)];s[2*f]=(u-d)*r,s[2*f+1]=(i[l+h]-i[c+h])*r,o=Math.max(o,s[2*f]**2+s[2*f+1]**2)}}return Math.sqrt(o)}var Id=class{constructor(t){this.about=t,this.surfaces=new Map,this.surface=null,this.dots=null,this.border=null,this.full=1,this.answer="missing",this.waiting=!0}},kx=new Set(["taxels"]),Hh=class{constructor(t,e){this.table=t,this.finest=e,this.group=new Yn,this.all=new Map,this.exaggeration=3,this.quantity="pressure",this.taxels=!0,this.bar=[0,1],this.theme=null,this.perMetre=1,this.ruling=.005}reset(t){for(let e of this.all.values()){for(let n of e.surfaces.values())n.dispose();e.dots?.dispose()}this.group.clear(),this.all.clear(),this.ruling=El(Math.max(.01,...t.map(({side:e})=>e||0))/9);for(let e of t)this.all.set(e.i,new Id(e))}setGeometry(t,e){let n=this.all.get(t.patch);if(!n)return;let s=n.surfaces.get(t.rung);e.taxels?.length&&e.taxel_normals&&this.#t(n,e),n.border??=Dx(e,n.about.pitch);let{table:r,finest:o}=this,a={table:r,finest:o,patches:this.all.size,border:n.border,ruling:this.ruling},l=new Vh(t,e,a);n.surfaces.set(t.rung,l),s&&(this.group.remove(s.mesh),s.dispose()),(n.surface===null||n.surface===s)&&(n.surface=l),this.group.add(l.mesh),this.#i(n)}#t(t,e){t.dots&&(this.group.remove(t.dots.mesh),t.dots.dispose());let n=t.about.pitch||.005;t.dots=new kh(e.taxels,e.taxel_normals,n,this.table),this.group.add(t.dots.mesh)}update(t,e,n=null){let s=this.all.get(t.i);if(!s)return;s.answer=t.answer,s.waiting=!1;let r=s.surfaces.get(t.rung)??s.surface,o=s.surfaces.has(t.rung)||t.height<0;if(r&&o){s.surface=r;let l=zx(e[t.height],r.nodes.given),c=zx(e[t.colour],r.nodes.given);r.setExaggeration(this.#n),r.setHeight(l,t.height_scale,t.height_zero??0),r.setColour(c,c?t.colour_lo:0,c?t.colour_hi:0)}let a=e[t.taxels];a&&s.dots&&s.dots.setReadings(a,e[t.repaired]),s.full=t.taxels_full??n??s.full,this.#i(s)}#i(t){let e=t.answer==="missing"&&!t.waiting;for(let s of t.surfaces.values()){s.mesh.visible=s===t.surface;let{uniforms:r}=s.material;r.missing.value=e?1:0,r.plain.value=kx.has(this.quantity)?1:0,r.bar.value.set(...this.bar),this.theme&&(r.grey.value.set(e?this.theme.missing:this.theme.plain),r.rim.value.set(this.theme.rim),r.ink.value.set(this.theme.line))}if(!t.dots)return;let n=this.quantity==="taxels";t.dots.mesh.visible=!e,t.dots.show(this.taxels||n,n),t.dots.setColours(t.full,this.bar),this.theme&&t.dots.setTheme(this.theme),t.dots.setSize(this.perMetre),t.surface&&t.dots.follow(t.surface)}get#n(){return kx.has(this.quantity)?0:this.exaggeration}refresh(){for(let t of this.all.values())t.surface?.setExaggeration(this.#n),this.#i(t)}setView(t){let e=this.exaggeration;for(let{surface:n,dots:s}of this.all.values())n&&(n.setView(t),s?.setDepth(n.scale),n.nodes.flat||(e=Math.min(e,n.times)));return e}setSize(t){this.perMetre=t;for(let{dots:e}of this.all.values())e?.setSize(t)}at(t,e,n,s,r=!1){let o=this.all.get(t)?.surface;return o?o.nodes.at(e,n,r?0:o.scale,s):!1}hit(t,e,n=!1){let s=null,r=-1;for(let[a,{surface:l}]of this.all){if(!l)continue;let c=l.nodes.hit(t,e,n?0:l.scale);!c||s&&c.distance>=s.distance||(s=c,r=a)}if(!s)return null;let o={position:[0,0,0],normal:[0,0,1]};return this.at(r,s.x,s.y,o,!0),{patch:r,x:s.x,y:s.y,position:o.position}}foot(t,e){let n=this.all.get(t).surface.rim.map(e),s=Math.max(...n.map(([,o])=>o)),r=n.filter(([,o])=>o>s-5);return[r.reduce((o,[a])=>o+a,0)/r.length,s]}subject(t){let e=[],n=new q,s=0;for(let{surface:r}of this.all.values()){if(!r)continue;let{position:o,outward:a,cover:l}=r.geometry.attributes,c=Math.max(1,Math.floor(l.count/500));for(let h=0;h<l.count;h+=1){let f=l.array[h];if(f<.4||f>.9&&h%c!==0)continue;let u=new q().fromBufferAttribute(o,h),d=new q().fromBufferAttribute(a,h);e.push(u,u.clone().addScaledVector(d,t)),n.add(d),s+=1}}return s>0&&n.divideScalar(s),{points:e,normal:n}}};function zx(i,t){return i&&i.length===t?i:null}function Vx(){let i=document.createElement("canvas").getContext("webgl2");if(!i)return!1;let t=i.getExtension("WEBGL_debug_renderer_info"),e=i.getParameter(t?t.UNMASKED_RENDERER_WEBGL:i.RENDERER);return i.getExtension("WEBGL_lose_context")?.loseContext(),/swiftshader|llvmpipe|software|basic render/i.test(String(e))}var eA="This browser shows no WebGL 2 pictures. The contacts are in the table, the rest works.",Gh=class{constructor(t,e){this.container=t,this.changed=e,this.software=Vx(),this.width=1,this.height=1,this.ratio=1,this.background="#000000",this.renderer=this.#t(),this.canvas=this.renderer?.domElement??document.createElement("canvas"),this.#i()}#t(){try{let t=new bh({antialias:!this.software});return t.outputColorSpace=dr,t}catch(t){let e=document.createElement("p");return e.textContent=eA,e.title=t.message,e.style.padding="1rem",this.container.append(e),null}}#i(){let{canvas:t}=this;t.dataset.testid="skin-canvas",t.tabIndex=0,t.setAttribute("role","img"),t.setAttribute("aria-label","The skin; its contacts are in the table beside it"),Object.assign(t.style,{display:"block",touchAction:"none",outlineOffset:"-3px"}),this.container.append(t),t.addEventListener("webglcontextlost",e=>e.preventDefault()),t.addEventListener("webglcontextrestored",()=>{this.setBackground(this.background),this.#n()}),this.observer=new ResizeObserver(()=>this.#n()),this.observer.observe(this.container)}#n(){this.width=Math.max(1,this.container.clientWidth),this.height=Math.max(1,this.container.clientHeight),this.ratio=Math.min(this.software?1:2,window.devicePixelRatio||1),this.renderer?.setPixelRatio(this.ratio),this.renderer?.setSize(this.width,this.height),this.changed()}setBackground(t){this.background=t,this.renderer?.setClearColor(t)}render(t,e){this.renderer?.render(t,e)}colourAt(t,e){let n=this.renderer.getContext(),s=new Uint8Array(4),r=n.drawingBufferHeight-1-Math.floor(e*this.ratio);return n.readPixels(Math.floor(t*this.ratio),r,1,1,n.RGBA,n.UNSIGNED_BYTE,s),[...s.subarray(0,3)]}};var Wh=class{constructor(t,e){this.canvas=t,this.scene=e,this.down=new Map,this.doing=null;let n=(s,r,o)=>t.addEventListener(s,r,o);n("pointerdown",s=>this.#i(s)),n("pointermove",s=>this.#s(s)),n("pointerup",s=>this.#h(s)),n("pointercancel",s=>this.#h(s)),n("pointerleave",()=>this.scene.hover(null)),n("contextmenu",s=>s.preventDefault()),n("wheel",s=>this.#c(s),{passive:!1})}#t(t){let e=this.canvas.getBoundingClientRect();return{x:t.clientX-e.left,y:t.clientY-e.top}}#i(t){let e=this.#t(t);if(this.down.set(t.pointerId,e),this.canvas.setPointerCapture(t.pointerId),this.scene.hover(null),this.down.size===2){this.#u(t),this.doing={kind:"pinch"};return}this.down.size>2||(t.button===1&&t.preventDefault(),this.doing=t.button===0?this.#n(e,t):{kind:"pan"})}#n(t,e){let{scene:n}=this;if(n.mode==="focus"){let s=n.pick(t.x,t.y);if(s)return{kind:"focus",patch:s.patch,first:s,last:s}}else if(n.pressable){let s=this.#e(t);if(s)return n.handlers.onPress?.("begin",{...s.place,id:s.id,event:e}),s}return{kind:"orbit"}}#e(t){let{scene:e}=this,n=e.pressNear(t.x,t.y,14),s=n??e.pick(t.x,t.y);if(!s)return null;let r=e.project(s.position);return{kind:"press",id:n?.id??null,place:{patch:s.patch,position:s.position},offset:{x:r.x-t.x,y:r.y-t.y}}}#s(t){let e=this.#t(t),n=this.down.get(t.pointerId);if(!n){this.down.size===0&&t.pointerType!=="touch"&&this.scene.hover(e);return}let s=e.x-n.x,r=e.y-n.y,{doing:o,scene:a}=this;o?.kind==="pinch"&&this.#o(t.pointerId,e),this.down.set(t.pointerId,e),o?.kind==="orbit"?a.orbit(s*.0085,r*.0085):o?.kind==="pan"?a.pan(s,r):o?.kind==="press"?this.#a(o,e,t):o?.kind==="focus"&&this.#r(o,e)}#a(t,e,n){let s=this.scene.pickAtRest(e.x+t.offset.x,e.y+t.offset.y);s&&(t.place={patch:s.patch,position:s.position},this.scene.handlers.onPress?.("move",{...t.place,id:t.id,event:n}))}#r(t,e){let n=this.scene.pickAtRest(e.x,e.y);!n||n.patch!==t.patch||(t.last=n,this.scene.sketchFocus(Hx(t)))}#o(t,e){let[n,s]=[...this.down.entries()].map(([c,h])=>c===t?e:h),[r,o]=[...this.down.values()],a=Math.hypot(n.x-s.x,n.y-s.y),l=Math.hypot(r.x-o.x,r.y-o.y);l>8&&a>8&&this.scene.zoom(a/l),this.scene.pan((n.x+s.x-r.x-o.x)/2,(n.y+s.y-r.y-o.y)/2)}#h(t){if(this.down.delete(t.pointerId)){if(this.doing?.kind==="pinch"){this.down.size===0&&(this.doing=null);return}this.down.size===0&&this.#u(t)}}#u(t){let{doing:e,scene:n}=this;if(this.doing=null,e?.kind==="press")n.handlers.onPress?.("end",{...e.place,id:e.id,event:t});else if(e?.kind==="focus"){let s=Hx(e);n.sketchFocus(null);let r=Math.min(s.high[0]-s.low[0],s.high[1]-s.low[1]);n.handlers.onFocus?.(r>5e-4?s:null)}}#c(t){t.preventDefault();let e=t.deltaMode===1?16:1;this.scene.zoom(Math.exp(-t.deltaY*e*.0012))}};function Hx({patch:i,first:t,last:e}){return{patch:i,low:[Math.min(t.x,e.x),Math.min(t.y,e.y)],high:[Math.max(t.x,e.x),Math.max(t.y,e.y)]}}var nA=.03,Xh=class{constructor(t,e={}){ge.enabled=!1,this.container=t,this.handlers=e,this.mode="press",this.skin="",this.focusOf=null,this.pressable=!1,this.toolOf={shape:"ball",radius:.004,force:1},this.picture=new Gh(t,()=>this.#t()),this.canvas=this.picture.canvas,this.table=iA(),this.patches=new Hh(this.table,this.picture.software?80/2:80),this.marks=new Bh(this.patches),this.view=new wh,this.root=new sa,this.root.add(this.patches.group,this.marks.group),this.map="viridis",this.waiting=[],this.requested=0,this.drawn=0,this.draw=this.draw.bind(this),this.setTheme("dark"),this.setColours({lo:0,hi:1}),this.pointer=new Wh(this.canvas,this)}#t(){let{width:t,height:e,ratio:n}=this.picture;this.view.resize(t,e),this.marks.setScreen(t,e,n),this.patches.setSize(n/this.view.pixel(1)),this.draw()}setSkin(t){let e=JSON.stringify([t.name,t.size,t.patches]);e!==this.skin&&(this.patches.reset(t.patches),this.view.moved=!1,this.focusOf=null),this.skin=e,this.marks.size=t.size||.1,this.marks.contacts=[],this.marks.truth=[],this.marks.shapes=[],this.marks.waiting=[],this.marks.focus=this.focusOf,this.marks.tool=null,this.pressable=!!t.press,this.redraw()}setGeometry(t,e){let n=this.patches.all.get(t.patch)?.surface;this.patches.setGeometry(t,e),n||this.#i(),this.redraw()}#i(){let{points:t,normal:e}=this.patches.subject(nA*this.marks.size);t.length>0&&this.view.setSubject(t,e)}update(t,e){let n=t.quantity==="taxels"?t.range?.[1]:null;for(let s of t.patches??[])this.patches.update(s,e,n);this.marks.contacts=t.contacts??[],this.marks.unit=tr(t.relative),this.marks.truth=t.truth??[],this.marks.shapes=t.shapes?.images??[],this.redraw()}setWaiting(t){(t.length||this.marks.waiting.length)&&this.redraw(),this.marks.waiting=t}setCovered(t){let{left:e,top:n}=this.canvas.getBoundingClientRect(),s=[...t].map(r=>r.getBoundingClientRect()).filter(({width:r})=>r>0);this.marks.covered=s.map(r=>({x:r.x-e,y:r.y-n,width:r.width,height:r.height})),this.redraw()}whenDrawn(){return new Promise(t=>{this.waiting.push(t),this.redraw()})}setTheme(t){let e=Is[t]??Is.dark,n=getComputedStyle(this.container).getPropertyValue("--scene-background").trim();this.picture.setBackground(n||e.background),this.marks.setTheme(e),this.patches.theme=e,this.theme=e,this.#n(),this.patches.refresh(),this.redraw()}#n(){this.table.image.data.set(Br(this.map,this.theme)),this.table.needsUpdate=!0}setExaggeration(t){this.patches.exaggeration=t,this.patches.refresh(),this.redraw()}setColours({lo:t,hi:e,map:n}){n&&(this.map=n,this.#n()),this.patches.bar=[t,e],this.patches.refresh(),this.redraw()}setQuantity(t){this.patches.quantity=t,this.patches.refresh(),this.redraw()}showTaxels(t){this.patches.taxels=!!t,this.patches.refresh(),this.redraw()}showLabels(t){this.marks.labelled=!!t,this.redraw()}setTool(t){this.toolOf={...this.toolOf,...t}}setMode(t){this.mode=t,this.hover(null)}setFocus(t){this.focusOf=t,this.marks.focus=t,this.redraw()}sketchFocus(t){this.marks.focus=t??this.focusOf,this.redraw()}orbit(t,e){this.view.orbit(t,e),this.redraw()}pan(t,e){this.view.pan(t,e),this.redraw()}zoom(t){this.view.zoom(t),this.redraw()}home(){this.#i(),this.view.home(),this.redraw()}project(t){let e=new q(...t).project(this.view.camera);return{x:(e.x+1)*.5*this.view.width,y:(1-e.y)*.5*this.view.height}}pick(t,e){return this.#e(t,e,!1)}pickAtRest(t,e){return this.#e(t,e,!0)}#e(t,e,n){let{camera:s,width:r,height:o}=this.view,a=new q(t/r*2-1,1-e/o*2,.5);return a.unproject(s).sub(s.position).normalize(),this.patches.hit(s.position.toArray(),a.toArray(),n)}colourAt(t,e){return this.draw(),this.picture.colourAt(t,e)}pressNear(t,e,n){let s={position:[0,0,0],normal:[0,0,1]};for(let{id:r,patch:o,position:a,x:l,y:c}of this.marks.truth){this.patches.at(o,l,c,s,!0);let h=this.project(s.position);if(Math.hypot(h.x-t,h.y-e)<=n)return{id:r,patch:o,position:a}}return null}hover(t){let e=t?this.pick(t.x,t.y):null,n=this.pressable&&this.mode==="press";this.marks.tool=e&&n?{...e,radius:this.toolOf.radius}:null,this.canvas.style.cursor=e&&(n||this.mode==="focus")?"crosshair":"grab",this.handlers.onPick?.(e?this.#s(e):""),this.redraw()}#s({patch:t,x:e,y:n}){let{name:s}=this.patches.all.get(t).about;return`${s}  x ${Gt(1e3*e)} mm  y ${Gt(1e3*n)} mm`}redraw(){this.requested||(this.requested=requestAnimationFrame(this.draw))}draw(){cancelAnimationFrame(this.requested),this.requested=0,this.marks.draw(this.view),this.picture.render(this.root,this.view.camera),this.drawn+=1;for(let t of this.waiting.splice(0))t()}};function iA(){return new go(new Uint8Array(1024),256,1)}var Ia=class extends Error{},qh=class{#t;#i=new URLSearchParams(location.search).get("token");#n=null;#e=new Map;#s=0;#a=250;#r=null;#o=0;#h=null;constructor(t){this.#t=t}get open(){return this.#n?.readyState===WebSocket.OPEN}connect(){clearTimeout(this.#r);let t=new WebSocket(this.#u("socket",location.protocol.replace("http","ws")));this.#n=t,t.binaryType="arraybuffer",t.onopen=()=>this.#c(),t.onmessage=({data:e})=>this.#f(e),t.onclose=({code:e,reason:n})=>this.#d(t,e,n),clearInterval(this.#h),this.#o=0,this.#h=setInterval(()=>this.#p(t),1e3)}restart(){this.#n?.close()}send(t){this.open&&this.#n.send(JSON.stringify(t))}ask(t){if(!this.open)return Promise.reject(new Ia("there is no connection"));let e=++this.#s;return new Promise((n,s)=>{this.#e.set(e,{resolve:n,reject:s}),this.send({...t,tag:e})})}#u(t,e=location.protocol){let n=new URL(t,location.href);return n.protocol=e,n.search=n.hash="",this.#i!==null&&n.searchParams.set("token",this.#i),n}#c(){this.#a=250,this.#o=0,this.#t.onOpen()}#f(t){if(this.#o=0,typeof t!="string")return this.#t.onBinary(t);let e;try{e=JSON.parse(t)}catch{e=null}e?.kind==="answer"?this.#l(e):this.#t.onText(e)}#l(t){let e=this.#e.get(t.tag);this.#e.delete(t.tag),e&&(t.ok?e.resolve(t):e.reject(new Ia(String(t.error??"the server refused, without a reason"))))}#p(t){this.#o+=1,!(t!==this.#n||this.#o<15)&&(this.#d(t),t.close())}#d(t,e=0,n=""){if(t===this.#n){this.#n=null,clearInterval(this.#h);for(let{reject:s}of this.#e.values())s(new Ia("the connection was lost"));this.#e.clear(),e===1013?this.#t.onRefused("full",n):this.#t.onLost(e===4008?n:""),this.#g()}}#g(){clearTimeout(this.#r),this.#r=setTimeout(async()=>{let t=await this.#m();t===401||t===403?this.#t.onRefused("token"):t===0?this.#g():this.connect()},this.#a),this.#a=Math.min(2*this.#a,2e3)}async#m(){try{let t=AbortSignal.timeout(5e3);return(await fetch(this.#u("api/status"),{cache:"no-store",signal:t})).status}catch{return 0}}};var sA=90;function rA({what:i,seconds_left:t}){let e=i==="compiling"?"Compiling once for this machine":"Preparing the skin";if(!Number.isFinite(t))return e;let n=Math.max(Math.round(t),1);return`${e}, ${n>sA?`${Math.round(n/60)} min`:`${n} s`} left`}function Wx(i){let t=X("preparing");if(t.hidden=!i,!i)return;let e=Math.round(100*Math.min(Math.max(i.done,0),1)),n=rA(i);le(t.querySelector(".preparing-text"),n),t.setAttribute("aria-valuenow",e),t.setAttribute("aria-valuetext",n),t.querySelector("i").style.width=`${e}%`}var oA=new Set(["running","live","playing","paused"]),aA=new Set(["starting","calibrating","connecting","mixed"]);var lA=6,qx=new Set(["playing","paused"]);function Nd(i){return oA.has(i)?"good":aA.has(i)?"waiting":"bad"}var cA=.05,hA=.02,uA=1e5;function fA(i,{unread_s:t=0,fades_s:e=.5}={}){let n=i.engines??[],s=n.filter(u=>Nd(u.state)==="bad").length;if(i.state==="mixed")return{state:"waiting",text:`${n.length-s} of ${n.length} engines run`};let r=Nd(i.state);if(r==="bad")return{state:r,text:i.state==="failed"?"The engine has ended":`The engine is ${i.state??"unknown"}`};if(i.state==="starting")return{state:r,text:"The engine starts"};if(i.state==="calibrating")return{state:r,text:"Taking the baseline: leave the skin untouched"};if(r==="waiting")return{state:r,text:i.state};let o=n.flatMap(dA);if(t>e&&!o.length)return{state:"bad",text:`No reading for ${Dd(t)}`};let a=mA(n,o);if(a)return{state:a.age<=e?"waiting":"bad",text:a.text};if(n.map(u=>u.notes?.failed).find(Boolean))return{state:"waiting",text:"Linear answers only"};if(i.preparing)return{state:"waiting",text:"Linear answers until the skin is prepared"};if(o.length)return{state:"waiting",text:pA(n,o)};let c=Ld(n,u=>$h(u).latency_us?.p50);if(c>uA)return{state:"waiting",text:`Estimates are ${Dd(c/1e6)} behind the skin`};let h=Ld(n,({lately:u})=>(u?.late??0)/Math.max(u?.cycles??0,1));if(h>cA)return{state:"waiting",text:`${Gt(100*h,0)} % of the estimates are late`};let f=Ld(n,gA);return f>hA?{state:"waiting",text:`${Gt(100*f,0)} % of the messages are lost`}:{state:"good",text:qx.has(i.state)?Yx(i.state):"Good"}}function Dd(i){return`${Gt(i,i<10?1:0)} s`}function dA({notes:i,patches:t}){let e=new Set((t??[]).filter(({answer:n})=>n==="linear").map(({name:n})=>n));return Object.entries(i?.searching??{}).map(([n,s])=>({name:n,seconds:s,linear:e.has(n)}))}function pA(i,t){t.sort((r,o)=>o.seconds-r.seconds);let[{seconds:e,linear:n}]=t,s=n?`linear answer for ${e} s: no time to search`:`search unfinished for ${e} s`;return $x(i,t,s)}function mA(i,t){let e=new Set(t.map(({name:o})=>o)),n=({age:o})=>o??1/0,s=i.flatMap(o=>o.patches??[]).filter(({stale:o,name:a})=>o&&!e.has(a));if(!s.length)return null;s.sort((o,a)=>n(a)-n(o));let r=n(s[0]);return{age:r,text:$x(i,s,r<1/0?`no reading for ${Dd(r)}`:"no reading yet")}}function $x(i,t,e){if(i.flatMap(s=>s.patches??[]).length<2)return Yx(e);let n=t.length-1;return`${t[0].name}${n?` and ${n} more`:""}: ${e}`}function Ld(i,t){return Math.max(0,...i.map(t).filter(Number.isFinite))}function gA({sources_lately:i}){let t=Object.values(i??{}),e=s=>t.reduce((r,o)=>r+(o[s]??0),0),n=e("lost")+e("overflowed");return n/Math.max(n+e("received"),1)}function Yx(i){return i.charAt(0).toUpperCase()+i.slice(1)}function xA(i){let e=(i.engines??[]).map(c=>$h(c).latency_us).filter(c=>c?.count!==0),n=c=>Math.max(...e.map(h=>h?.[c]).filter(Number.isFinite)),{updates_per_s:s,bytes_per_s:r,clients:o}=i.page??i,a=[];Number.isFinite(n("p50"))&&a.push(`latency ${er(n("p50"))}, p99 ${er(n("p99"))}`),Number.isFinite(s)&&a.push(`${Gt(s,0)} updates/s, ${Ga(r)}/s`);let l=(o??1)-1;return l>0&&a.push(`${l} other${l>1?"s":""} look${l>1?"":"s"} on`),a}function Xx({mode:i,press:t}){return i==="replay"?"recording":t?"simulated":"live"}function $h(i){let{late:t=i.late}=i.since_start??{};return{latency_us:i.latency_us??i.lately?.latency_us,late:t}}var Yh=class{#t=X("status-line");#i=!1;#n="live";#e=null;#s={};connection(t){this.#i=t!==null,document.body.classList.toggle("lost",this.#i),X("main").inert=this.#i,this.#i&&this.#r("waiting",t)}refused(t,e){this.connection(t),le(X("mode"),e)}hello(t){let{mode:e,name:n}=t;this.#n=e,this.#e=null,le(X("mode"),Xx(t)),X("mode").dataset.mode=Xx(t),X("mode").title=e==="remote"?"A skin elsewhere: this page only looks on":"",le(X("skin-name"),n??""),X("skin-name").title=n??"",document.title=n?`${n} · skinfield`:"skinfield"}show(t){if(this.#e=t,this.#i)return;this.#a();let e=xA(t).map(n=>n.replaceAll(" "," ")).join(" · ");le(X("health-text"),e),this.#o(t.engines??[]),this.#h((t.engines??[]).flatMap(_A))}unread(t){this.#s=t,this.#e&&!this.#i&&this.#a()}#a(){let{state:t,text:e}=fA(this.#e,this.#s),n=this.#n==="replay"&&!qx.has(this.#e.state)&&this.#e.engines?.length;this.#r(t,n?`Live skin: ${e}`:e)}#r(t,e){this.#t.dataset.state=t,le(this.#t.querySelector(".status-text"),e),this.#t.title=e}#o(t){let e=t.map(n=>{let s=qt("td",{class:`state ${Nd(n.state)}`,text:n.state});return qt("tr",{"data-engine":n.name},qt("th",{scope:"row",text:n.name,title:n.name}),s,qt("td",{class:"n",text:hu(n.rate)}),qt("td",{class:"n",text:Gt($h(n).latency_us?.p99,0)}),qt("td",{class:"n",text:hu($h(n).late)}))});X("engines").tBodies[0].replaceChildren(...e)}#h(t){let e=[...new Set(t)].slice(0,lA),n=e.join(`
`);X("notes").dataset.key!==n&&(X("notes").dataset.key=n,X("notes").replaceChildren(...e.map(s=>qt("li",{text:s}))))}};function _A({error:i,viewer_notes:t}){return[i,...t??[]].filter(e=>typeof e=="string"&&e!=="")}var Zx={u8:Uint8Array,u16:Uint16Array,u32:Uint32Array,f32:Float32Array},Ln=class extends Error{};function Jx(i){if(!(i instanceof ArrayBuffer)||i.byteLength<8)throw new Ln("too short");let t=new DataView(i);if(t.getUint32(0,!0)!==826690387)throw new Ln("does not begin with SKF1");let e=8+t.getUint32(4,!0);if(e>i.byteLength)throw new Ln("ends within its head");if(e%8)throw new Ln("its arrays do not begin at a multiple of 8");let n=vA(new Uint8Array(i,8,e-8)),s=n.arrays.map(r=>yA(i,e,r));return s.byName=Object.create(null),n.arrays.forEach((r,o)=>s.byName[r.name]=s[o]),{head:n,arrays:s}}function vA(i){let t;try{t=JSON.parse(new TextDecoder("utf-8",{fatal:!0}).decode(i))}catch{throw new Ln("its head is not JSON")}if(!Na(t)||typeof t.kind!="string")throw new Ln("its head has no kind");if(!Array.isArray(t.arrays))throw new Ln("its head lists no arrays");return t}function yA(i,t,e){let n=Na(e)&&Object.hasOwn(Zx,e.type)?Zx[e.type]:null;if(!n||typeof e.name!="string")throw new Ln("an array of unknown type");let{at:s,length:r}=e;if(!jn(s)||s%4||!jn(r))throw new Ln("an array at no valid place");if(t+s+r*n.BYTES_PER_ELEMENT>i.byteLength)throw new Ln(`ends within its array ${e.name}`);return new n(i,t+s,r)}function Kx({head:i,arrays:t}){Ze(jn(i.patch)&&jn(i.rung),"a geometry without patch and rung"),Ze(jn(i.rows)&&jn(i.columns),"a geometry without rows and columns");let e=i.rows*i.columns,n={positions:3*e,normals:3*e,plane:2*e,covered:e};for(let[o,a]of Object.entries(n))Ze(t.byName[o]?.length===a,`a geometry whose ${o} are not ${a} long`);let{taxels:s,taxel_normals:r}=t.byName;return Ze(!s||s.length%3===0&&r?.length===s.length,"taxels without normals"),{head:i,arrays:t}}function jx({head:i,arrays:t}){Ze(jn(i.number),"an update without number");for(let e of["patches","contacts","truth"])i[e]??=[],Ze(Array.isArray(i[e])&&i[e].every(Na),`an update whose ${e} are no list`);for(let e of i.patches)MA(e,t);for(let e of[...i.contacts,...i.truth])Ze(jn(e.patch),"a contact without patch"),Ze(La(e.position)&&La(e.normal),"a contact without place"),Ze(Number.isFinite(e.force),"a contact without force"),e.shear??=null,Ze(e.shear===null||wA(e.shear),"a force along the skin without its numbers"),e.border??=null,Ze(e.border===null||Qx(e.border),"a border without places");for(let e of i.contacts)e.outline??=[],Ze(Array.isArray(e.outline)&&e.outline.every(La),"an outline without places"),e.place_cov??=[null,null,null],Ze(Array.isArray(e.place_cov)&&e.place_cov.length===3,"a covariance without its numbers");return i.shapes!=null&&bA(i.shapes),{head:i,arrays:t}}function bA(i){Ze(Na(i)&&typeof i.why=="string","shapes without a word"),Ze(Array.isArray(i.images)&&i.images.every(Na),"shapes without images");for(let t of i.images)Ze(jn(t.patch)&&jn(t.track),"an image without patch and track"),Ze(jn(t.rows)&&jn(t.columns)&&t.cell>0,"an image without cells"),Ze(La(t.pose)&&Zh(t.low,2),"an image without place"),Ze(Zh([t.peak,t.force,t.area,t.readings],4),"an image without numbers"),Ze(Array.isArray(t.outline)&&t.outline.every(Qx),"an image without outline"),t.bytes=SA(t.pressure),Ze(t.bytes.length===t.rows*t.columns,"an image whose pressures are not all there")}function SA(i){try{return Uint8Array.from(atob(i),t=>t.charCodeAt(0))}catch{throw new Ln("an image whose pressures are no base64")}}function MA(i,t){Ze(jn(i.i),"a patch without number");let e={height:Uint16Array,colour:Uint16Array,taxels:Uint8Array,repaired:Uint8Array};for(let[n,s]of Object.entries(e))i[n]??=-1,Ze(i[n]===-1||t[i[n]]instanceof s,`a patch without its ${n}`);i.height_zero??=0,Ze(jn(i.height_zero),"heights without the one of skin at rest")}function wA({size:i,angle:t,vector:e}){return[i,t].every(Number.isFinite)&&La(e)}function Ze(i,t){if(!i)throw new Ln(t)}function Na(i){return typeof i=="object"&&i!==null&&!Array.isArray(i)}function jn(i){return Number.isSafeInteger(i)&&i>=0}function La(i){return Zh(i,3)}function Qx(i){return Array.isArray(i)&&i.every(t=>Zh(t,2))}function Zh(i,t){return Array.isArray(i)&&i.length===t&&i.every(Number.isFinite)}var EA="connection lost, trying again …",TA=2e3,AA=1e3,RA=20,we={hello:null,controls:null,status:null,lastUpdate:null,contacts:[],truth:[],connections:0,updates:0,bytes:0,pressed:ka("pressed")!==null,malformed:[]},bs=new qh({onOpen:CA,onLost:i=>To.connection(i?`${i}, trying again …`:EA),onRefused:r_,onText:IA,onBinary:FA}),ke=new Xh(X("scene"),{onPress:(i,t)=>es.gesture(i,t),onFocus:i=>Eo.focusDrawn(i),onPick:i=>le(X("skin-name"),i||(we.hello?.name??""))}),To=new Yh,i_=new Ka,Js=new yl(X("force-plot"),X("latency-plot")),Kh=new Ya(i=>ke.setColours(i)),Eo=new el(Da,ke,o_),es=new Sl(i=>((i.do==="press"||i.do==="move")&&di.live(),Da(i)),ke),Fd=new Tl(Da),di=new wl(Da,s_,GA),Ud=new Wi(h_),Er=new Ha({rows:()=>document.querySelectorAll("#contacts-table tr[data-key]"),scene:ke,unread:i=>To.unread(i)});async function Da(i){return await s_(i)!==null}async function s_(i){try{return await bs.ask(i)}catch(t){return bs.open&&Xi("error",t.message),null}}function CA(){we.connections+=1,To.connection(null),es.forget(),Bd()}var PA={token:["This page needs its token","Open the address that skinfield run printed: it ends with ?token=…."],full:["No place is free","Close one of the browsers that look on. This page comes in by itself as soon as there is a place."]};function r_(i,t=""){if(X("refused").hidden=!i,X("main").hidden=!!i,!i)return;let[e,n]=PA[i];le(X("refused-title"),e),le(X("refused-text"),[t,n].filter(Boolean).join(". ")),To.refused(e,i==="full"?"full":"locked")}function Od(){let{hello:i,status:t}=we,e=i?.press&&t?.state==="running"&&!we.controls?.off?.press;le(X("invitation"),`Simulated skin: ${Va()?"tap":"click"} to press it`),X("invitation").hidden=!e||we.pressed}function o_(i){return we.hello?.patches?.[i]?.name??String(i)}function IA(i){let e={hello:LA,controls:NA,status:DA,notice:UA,timeline:s=>{di.timeline(s),Js.recall(s.contacts??{})}},n=Object.hasOwn(e,i?.kind??"")?e[i.kind]:null;if(!n)return Jh("a message of no known kind");try{n(i)}catch(s){Jh(s.message),console.debug(s)}}function LA(i){if(i.wire!==1)return Xi("error",`the server speaks wire ${i.wire}, this page ${1}: load it again`);we.hello&&i.version!==we.hello.version&&Xi("warn",`the server is skinfield ${i.version} now: load the page again to be sure`),r_(null);let t=e_(i)!==e_(we.hello);Object.assign(we,{hello:i,lastUpdate:null,contacts:[],truth:[]}),ke.setSkin(i);for(let e of[To,es,di,Fd])e.hello(i);Er.passes(i.mode!=="replay"),Od(),t&&(Js.clear(),i_.clear(),Kh.reset()),le(X("help-version"),`skinfield ${i.version}.`),document.body.dataset.mode=i.mode,document.body.classList.toggle("one-patch",i.patches.length===1)}function e_(i){return i&&JSON.stringify([i.mode,i.name,i.patches,i.replay])}function NA(i){we.controls=i;for(let t of[Eo,es,di])(t.show??t.controls).call(t,i);Js.setDeadline(i.deadline_us?.value),Ud.settled(),Ud.has("quantity")||h_()}function DA(i){we.status=i,To.show(i),Wx(i.preparing),Od(),ke.setCovered([X("preparing"),X("invitation")])}function UA({level:i,text:t}){Xi(i,String(t))}function FA(i){we.bytes+=i.byteLength??0;let t;try{if(t=Jx(i),t.head.kind==="geometry")OA(Kx(t));else if(t.head.kind==="update")kA(jx(t),i.byteLength);else throw new Ln(`a binary message of kind ${t.head.kind}`)}catch(e){Jh(e.message),e instanceof Ln||console.debug(e),BA(t?.head)}}function OA({head:i,arrays:t}){ke.setGeometry(i,t.byName)}function BA(i){if(Number.isSafeInteger(i?.number))return bs.send({do:"ack",number:i.number});if(i)return;let t=we.updates;setTimeout(()=>we.updates===t&&bs.restart(),TA)}function Jh(i){we.malformed=[...we.malformed,String(i)].slice(-RA),Xi("warn",`a message from the server was passed over: ${i}`)}async function kA({head:i,arrays:t},e){try{let{hello:n}=we;i.came_ms=performance.now(),di.keep(a_(i),i,t,e);let s=di.lookingBack?i:VA(i,t);await zA(),we.hello===n&&HA(s)}catch(n){Jh(n.message),console.debug(n)}Er.drawn(),bs.send({do:"ack",number:i.number})}function zA(){if(document.hidden)return new Promise(t=>setTimeout(t,AA));let i=new Promise(t=>document.addEventListener("visibilitychange",t,{once:!0}));return Promise.race([ke.whenDrawn(),i])}function a_({time_s:i,stamp_ns:t}){return Number.isFinite(i)?i:t>0?t*1e-9:NaN}function VA(i,t){Kh.follow(i,performance.now()/1e3);let e=Er.update(i);return ke.update(e,t),e}function HA(i){if(we.updates+=1,es.seen(i.truth),i.truth.length&&!we.pressed&&(we.pressed=!0,za("pressed","yes"),Od()),di.lookingBack)return;Js.add(a_(i),l_(i),i),di.at(i.time_s);let t=ng(i.latency_us,we.controls?.deadline_us?.value);X("latency-plot").setAttribute("aria-label",`Latency of the estimates, now ${t}`)}function GA({time:i,head:t,parts:e},n=!1){Er.passes(n);let s=Er.update(t,t.came_ms);Er.drawn(t.came_ms);let r=Map.groupBy(e.values(),({arrays:o})=>o);s.quantity!==we.lastUpdate?.quantity&&ke.setQuantity(s.quantity),Kh.follow(s,performance.now()/1e3),ke.update({...s,patches:[]},[]);for(let[o,a]of r)ke.update({...s,patches:a.map(({entry:l})=>l)},o);l_(s),Js.until(n?null:i)}function l_(i){let t=performance.now()/1e3;Object.assign(we,{lastUpdate:i,contacts:i.contacts,truth:i.truth});let e=Za(i.contacts,i.truth);Fd.show(i),i_.show(e,i.truth,{now:t,patchName:o_,slotOf:o=>Js.slotOf(o),none:WA(),relative:i.relative});for(let o of document.querySelectorAll(".force-unit"))le(o,tr(i.relative)),o.title=i.relative?"relative: forces hold up to one factor until the skin is calibrated":"";let{length:n}=i.contacts,s=n>0||c_();le(X("readout-force"),s?`${Gt(vu(i.contacts),2)} ${tr(i.relative)}`:"–");let r=s?"no contact":"no answer";return le(X("readout-count"),n?`${n} contact${n>1?"s":""}`:r),Er.look(),e}function c_(){let{state:i}=we.status??{};return!i||we.hello?.mode==="replay"||i==="running"||i==="mixed"}function WA(){return c_()?"No contact":`No answer: ${we.controls?.busy??`the engine is ${we.status.state}`}`}async function Bd(){let i=X("quantity");di.live(),ke.setQuantity(i.value),await Ud.wait("quantity",Da({do:"show",quantity:i.value}))}function h_(){let i=we.controls?.quantity,t=X("quantity");!i||!bs.open||t.value===i||(t.value=i,ke.setQuantity(i))}function XA(i){X("quantity").value=i,Bd()}function n_(){let i=10**X("exaggeration").valueAsNumber;le(X("exaggeration-text"),`×${Gt(i,i<9.95?1:0)}`),ke.setExaggeration(i)}function qA(){let i=we.hello?.name||"skin",t=[X("readout-force"),X("readout-count"),X("colour-name")].map(n=>n.textContent),e=new Date().toISOString().slice(0,19).replace("T"," ");Sp(`${i}.png`,ke,[t.join(" · "),`${i} · ${e} UTC`])}function $A(){X("quantity").addEventListener("change",Bd),X("exaggeration").addEventListener("input",n_),X("show-taxels").addEventListener("change",i=>ke.showTaxels(i.target.checked)),X("show-labels").addEventListener("change",i=>ke.showLabels(i.target.checked)),X("export-png").addEventListener("click",qA),X("home").addEventListener("click",()=>ke.home()),X("plot-window").addEventListener("change",i=>Js.setWindow(Number(i.target.value))),X("refused-again").addEventListener("click",()=>bs.connect()),X("help-open").addEventListener("click",()=>X("help").showModal()),X("help-close").addEventListener("click",()=>X("help").close()),n_(),ke.showLabels(X("show-labels").checked),ke.showTaxels(X("show-taxels").checked)}addEventListener("pointerdown",()=>document.body.dataset.input="pointer",!0);addEventListener("keydown",()=>document.body.dataset.input="keys",!0);addEventListener("pagehide",()=>es.leave());$A();vp(i=>{ke.setTheme(i),Kh.recolour(i),Js.recolour(),di.recolour(),Fd.recolour(i)});Ep({orbit:(i,t)=>ke.orbit(i,t),zoom:i=>ke.zoom(i),home:()=>ke.home(),shift:(i,t)=>es.shift(i,t),harder:i=>es.harder(i),step:i=>di.step(i),loop:()=>di.loop(),quantity:XA,tare:()=>Eo.tare(),record:()=>Eo.record(),play:()=>di.toggle(),lift:()=>Eo.drawing?Eo.draw(!1):es.liftAll(),press:()=>es.pressMiddle(),help:()=>X("help").showModal()});bs.connect();window.skinfield={scene:ke,state:we,socket:bs};})();
